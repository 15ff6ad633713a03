// SPDX-License-Identifier: Apache-2.0
package reve.core.unit;

import tech.units.indriya.AbstractUnit;
import tech.units.indriya.format.EBNFUnitFormat;
import tech.units.indriya.format.SymbolMap;
import tech.units.indriya.format.TokenMgrError;
import tech.units.indriya.unit.UnitDimension;
import tech.units.indriya.unit.Units;

import java.util.Locale;
import java.util.Map;
import java.util.ResourceBundle;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

import javax.measure.Dimension;
import javax.measure.UnitConverter;

/**
 * Text to {@link Unit} by way of the units library. Its grammar is wider than a unit of ours
 * (logarithms, offsets, numeric factors), so the text is narrowed first and the result checked.
 */
final class UnitParser {
    private static final int MAX_LENGTH = 64;
    private static final Pattern ALLOWED = Pattern.compile("[\\p{L}%°℃0-9²³*·/^()\\-]+");
    private static final Pattern NAME = Pattern.compile("[\\p{L}%°℃]+");

    /** Largest product of all exponents: the library takes a step of recursion for each. */
    private static final int MAX_POWER = 1000;

    private static final Pattern NUMBER = Pattern.compile("(\\^-?)?\\d+");
    private static final Map<Dimension, SiBase> BASES =
            Map.of(
                    UnitDimension.LENGTH, SiBase.METRE,
                    UnitDimension.MASS, SiBase.KILOGRAM,
                    UnitDimension.TIME, SiBase.SECOND,
                    UnitDimension.ELECTRIC_CURRENT, SiBase.AMPERE,
                    UnitDimension.TEMPERATURE, SiBase.KELVIN,
                    UnitDimension.AMOUNT_OF_SUBSTANCE, SiBase.MOLE,
                    UnitDimension.LUMINOUS_INTENSITY, SiBase.CANDELA);
    private static final EBNFUnitFormat FORMAT = EBNFUnitFormat.getInstance(symbols());

    private UnitParser() {}

    static Unit parse(String text) {
        String symbol = normalise(text);
        if (symbol.equals("1")) {
            return Unit.ONE;
        }
        checkForm(text, symbol);
        AbstractUnit<?> unit = parseWithLibrary(text, symbol);
        double scale = scale(text, unit);
        return new Unit(exponents(text, unit.getDimension()), scale, symbol);
    }

    /** The library's base symbols whatever the machine's language, and a few that it lacks. */
    private static SymbolMap symbols() {
        SymbolMap symbols =
                SymbolMap.of(
                        ResourceBundle.getBundle(
                                "tech.units.indriya.format.messages", Locale.ROOT));
        var degree = Units.RADIAN.multiply(Math.PI / 180);
        symbols.alias(degree, "deg");
        symbols.alias(degree, "°");
        symbols.alias(Units.KILOGRAM.multiply(1000), "t");
        symbols.alias(Units.LITRE, "L");
        symbols.alias(Units.OHM, "ohm");
        return symbols;
    }

    /** One code point for each of the look-alikes: micro sign and mu, ohm sign and omega, dots. */
    private static String normalise(String text) {
        return text.strip().replace('μ', 'µ').replace('\u2126', 'Ω').replace('⋅', '·');
    }

    private static void checkForm(String text, String symbol) {
        if (symbol.isEmpty()) {
            throw refuse(text, "it is empty; a plain number has the unit 1");
        }
        if (symbol.length() > MAX_LENGTH) {
            throw refuse(
                    text.substring(0, MAX_LENGTH) + "…",
                    "it is longer than " + MAX_LENGTH + " characters");
        }
        if (!ALLOWED.matcher(symbol).matches()) {
            throw refuse(text, "only names, * · / ^ ( ) and whole exponents make a unit");
        }
        Matcher number = NUMBER.matcher(symbol);
        long power = 1;
        while (number.find()) {
            boolean exponent = number.group(1) != null;
            String digits = number.group().replaceAll("\\D", "");
            if (exponent) {
                power *= digits.length() > 3 ? MAX_POWER + 1 : Integer.parseInt(digits);
            }
            if (power > MAX_POWER) {
                throw refuse(text, "its exponents are too large");
            }
            boolean leadingOne = number.start() == 0 && symbol.startsWith("1/");
            if (!exponent && !leadingOne) {
                throw refuse(
                        text,
                        "the number "
                                + number.group()
                                + " is no exponent; write m^2 for square metres");
            }
        }
    }

    private static AbstractUnit<?> parseWithLibrary(String text, String symbol) {
        try {
            return (AbstractUnit<?>) FORMAT.parse(symbol);
        } catch (RuntimeException | TokenMgrError notAUnit) {
            Matcher name = NAME.matcher(symbol);
            while (name.find()) {
                if (!known(name.group())) {
                    throw refuse(text, "`" + name.group() + "` is not a unit that is known here");
                }
            }
            throw refuse(text, "it is not well formed; write it like kg*m^2/s^2 or N/m");
        }
    }

    private static double scale(String text, AbstractUnit<?> unit) {
        try {
            UnitConverter toSi = unit.getSystemConverter();
            double scale = toSi.convert(1.0);
            if (toSi.isLinear() && Double.isFinite(scale) && scale > 0) {
                return scale;
            }
        } catch (UnsupportedOperationException offsetWithinProduct) {
            // refused below, like an offset unit on its own
        }
        throw refuse(text, "it is not a plain multiple of SI units (for temperatures use K)");
    }

    private static boolean known(String name) {
        try {
            FORMAT.parse(name);
            return true;
        } catch (RuntimeException | TokenMgrError unknown) {
            return false;
        }
    }

    private static byte[] exponents(String text, Dimension dimension) {
        byte[] exponents = new byte[SiBase.values().length];
        var factors = dimension.getBaseDimensions();
        if (factors == null) { // a base dimension itself
            factors = Map.of(dimension, 1);
        }
        factors.forEach(
                (factor, exponent) -> {
                    SiBase base = BASES.get(factor);
                    if (base == null || exponent != exponent.byteValue()) {
                        throw refuse(text, "its dimension " + dimension + " is out of range");
                    }
                    exponents[base.ordinal()] = exponent.byteValue();
                });
        return exponents;
    }

    private static IllegalArgumentException refuse(String text, String why) {
        return new IllegalArgumentException("unit `" + text + "`: " + why);
    }
}
