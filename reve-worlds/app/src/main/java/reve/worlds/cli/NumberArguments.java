// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine;
import picocli.CommandLine.TypeConversionException;

import java.util.regex.Pattern;

/**
 * Conversion of the numbers on a command line. Unlike the conversions of the library, it accepts
 * only ASCII digits and finite numbers, and its messages state what is expected.
 */
final class NumberArguments {
    private static final Pattern WHOLE = Pattern.compile("[-+]?[0-9]+");
    private static final Pattern DECIMAL =
            Pattern.compile("[-+]?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][-+]?[0-9]+)?");

    private NumberArguments() {}

    /** Lets a command line and its subcommands use these conversions. */
    static void register(CommandLine line) {
        line.registerConverter(Integer.class, NumberArguments::integer);
        line.registerConverter(int.class, NumberArguments::integer);
        line.registerConverter(Long.class, NumberArguments::large);
        line.registerConverter(long.class, NumberArguments::large);
        line.registerConverter(Double.class, NumberArguments::decimal);
        line.registerConverter(double.class, NumberArguments::decimal);
    }

    private static Integer integer(String given) {
        return (int) whole(given, Integer.MIN_VALUE, Integer.MAX_VALUE);
    }

    private static Long large(String given) {
        return whole(given, Long.MIN_VALUE, Long.MAX_VALUE);
    }

    private static long whole(String given, long least, long most) {
        if (!WHOLE.matcher(given).matches()) {
            throw new TypeConversionException("found '" + given + "', expected a whole number");
        }
        try {
            long number = Long.parseLong(given);
            if (number >= least && number <= most) {
                return number;
            }
        } catch (NumberFormatException tooLarge) {
            // The exception is ignored. The message after this block reports the number.
        }
        throw new TypeConversionException(
                "found '"
                        + given
                        + "', expected a whole number "
                        + (given.startsWith("-") ? "from " + least + " on" : "up to " + most));
    }

    private static Double decimal(String given) {
        if (DECIMAL.matcher(given).matches()) {
            double number = Double.parseDouble(given);
            if (Double.isFinite(number)) {
                return number;
            }
        }
        throw new TypeConversionException(
                "found '" + given + "', expected a finite number without a unit, such as 2.5");
    }
}
