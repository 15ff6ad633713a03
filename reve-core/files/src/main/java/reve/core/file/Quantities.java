// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;

import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.function.DoubleUnaryOperator;
import java.util.regex.MatchResult;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Reader of the numbers of a world file: {@code 3}, {@code [0, 3, 0]}, {@code 3 kg}, {@code 0 3 0
 * km/h} or {@code "[0, 3, 0] km/h"}. A number without a unit is in the expected unit. A number with
 * a unit is converted to the expected unit.
 */
final class Quantities {
    /** Maximum length of a text with numbers [characters]. */
    private static final int MAX_LENGTH = 1024;

    private static final Pattern NUMBER =
            Pattern.compile("[+-]?(?:\\d++(?:\\.\\d*+)?|\\.\\d++)(?:[eE][+-]?\\d++)?");
    private static final Pattern NOT_FINITE =
            Pattern.compile("[+-]?\\.?(nan|inf|infinity)", Pattern.CASE_INSENSITIVE);
    private static final Pattern NO_SPACE =
            Pattern.compile("(?<number>" + NUMBER + ")(?<unit>[\\p{L}°%].*)");
    private static final Pattern LIST = Pattern.compile("\\[([^\\[\\]]*)\\](.*)");
    private static final Pattern DECIMAL_COMMA = Pattern.compile("\\d+,\\d+");
    private static final Pattern GAP = Pattern.compile("\\s*,\\s*|\\s+");

    private final Problems problems;

    /** Cache of parsed units by text. It saves time because many items use the same few units. */
    private final Map<String, Unit> units = new HashMap<>();

    Quantities(Problems problems) {
        this.problems = problems;
    }

    /**
     * Returns one number in {@code unit}. Records a problem and returns empty if the value is
     * wrong.
     */
    Optional<Double> number(Node node, Unit unit) {
        return numbers(node, 1, unit).map(values -> values[0]);
    }

    /**
     * Returns {@code count} numbers in {@code unit}. Records a problem and returns empty if the
     * value is wrong.
     */
    Optional<double[]> numbers(Node node, int count, Unit unit) {
        if (node.text().isPresent()) {
            return fromText(node, count, unit);
        }
        if (node.isList()) {
            return fromList(node, count, unit);
        }
        return node.number().flatMap(number -> counted(node, new double[] {number}, count, unit));
    }

    /**
     * A number with any unit.
     *
     * @param value in SI units
     * @param unit the unit in the file, if any
     */
    record Quantity(double value, Optional<Unit> unit) {}

    /**
     * Returns one number with any unit. Records a problem and returns empty if the value is wrong.
     */
    Optional<Quantity> quantity(Node node) {
        if (node.text().isEmpty()) {
            return node.number().map(value -> new Quantity(value, Optional.empty()));
        }
        return anyUnit(node, 1).map(read -> new Quantity(read.values()[0], read.unit()));
    }

    /**
     * Numbers with any unit.
     *
     * @param values one number, or three numbers of a vector, in SI units
     * @param unit the unit in the file, if any
     */
    record NumberOrVector(double[] values, Optional<Unit> unit) {}

    /**
     * Returns one number with any unit, or three numbers of a vector with one unit. Records a
     * problem and returns empty if the value is wrong.
     */
    Optional<NumberOrVector> numberOrVector(Node node) {
        if (node.isList()) {
            return fromList(node, 3, Unit.ONE)
                    .map(values -> new NumberOrVector(values, Optional.empty()));
        }
        return node.text().isPresent()
                ? anyUnit(node, 3)
                : quantity(node)
                        .map(one -> new NumberOrVector(new double[] {one.value()}, one.unit()));
    }

    /**
     * @param most 1 for one number; 3 for one number or three
     */
    private Optional<NumberOrVector> anyUnit(Node node, int most) {
        Optional<Parsed> parsed = parse(node, "a number with a unit, such as `3 m/s`");
        if (parsed.isEmpty()) {
            return Optional.empty();
        }
        Unit from = parsed.get().unit.orElse(Unit.ONE);
        double[] numbers = parsed.get().numbers;
        if (numbers.length != 1 && numbers.length != most) {
            return refuse(
                    node,
                    "found "
                            + plural(numbers.length)
                            + ", expected one"
                            + (most == 1 ? "" : ", or the three of a vector")
                            + commaHint(node, 1));
        }
        return finite(node, numbers, from, from::toSi)
                .map(values -> new NumberOrVector(values, parsed.get().unit));
    }

    private record Parsed(double[] numbers, Optional<Unit> unit) {}

    private Optional<double[]> fromText(Node node, int count, Unit unit) {
        Optional<Parsed> parsed = parse(node, expected(count, unit));
        if (parsed.isEmpty()) {
            return Optional.empty();
        }
        Unit from = parsed.get().unit.orElse(unit);
        if (!from.sameDimension(unit)) {
            return refuse(node, "unit " + from + " does not fit " + unit);
        }
        return counted(node, parsed.get().numbers, count, unit)
                .flatMap(numbers -> finite(node, numbers, from, n -> from.convert(n, unit)));
    }

    private Optional<double[]> fromList(Node node, int count, Unit unit) {
        double[] numbers = new double[node.children().size()];
        int next = 0;
        for (Node element : node.children()) {
            if (element.number().isEmpty()) {
                problems.add(
                        element,
                        node.label()
                                + ": found "
                                + element.describe()
                                + " in a list of numbers; a unit goes behind all of them, as in `"
                                + example(count, unit)
                                + "`");
                return Optional.empty();
            }
            numbers[next++] = element.number().get();
        }
        return counted(node, numbers, count, unit);
    }

    private Optional<double[]> counted(Node node, double[] numbers, int count, Unit unit) {
        return numbers.length == count
                ? Optional.of(numbers)
                : refuse(
                        node,
                        "found "
                                + plural(numbers.length)
                                + ", expected "
                                + expected(count, unit)
                                + commaHint(node, count));
    }

    private static String commaHint(Node node, int count) {
        Matcher comma = DECIMAL_COMMA.matcher(node.text().orElse(""));
        List<String> numbers = comma.results().map(MatchResult::group).toList();
        return numbers.size() != count
                ? ""
                : "; a decimal point is written `.`, as in `"
                        + numbers.getFirst().replace(',', '.')
                        + "`";
    }

    /** Splits a text into the numbers at its start and the unit after them. */
    private Optional<Parsed> parse(Node node, String expected) {
        String text = node.text().orElseThrow().strip();
        if (text.length() > MAX_LENGTH) {
            return refuse(
                    node, "found a text of " + text.length() + " characters, expected " + expected);
        }
        Matcher list = LIST.matcher(text);
        boolean bracketed = list.matches();
        String[] words = GAP.split(bracketed ? list.group(1).strip() : text);
        for (String word : words) {
            if (NOT_FINITE.matcher(word).matches()) {
                return refuse(node, "`" + word + "` is not a finite number");
            }
        }
        int count = 0;
        while (count < words.length && NUMBER.matcher(words[count]).matches()) {
            count++;
        }
        double[] numbers = new double[count];
        for (int i = 0; i < count; i++) {
            numbers[i] = Double.parseDouble(words[i]);
            if (Double.isInfinite(numbers[i])) {
                return refuse(
                        node, "`" + Node.shorten(words[i]) + "` is too large for a 64-bit number");
            }
        }
        if (count == 0 || bracketed && count < words.length) {
            return refuse(node, noNumber(words[count], text, expected));
        }
        String unit =
                bracketed
                        ? list.group(2).strip()
                        : String.join(" ", Arrays.asList(words).subList(count, words.length));
        return unit.isEmpty()
                ? Optional.of(new Parsed(numbers, Optional.empty()))
                : unit(node, unit).map(read -> new Parsed(numbers, Optional.of(read)));
    }

    private Optional<Unit> unit(Node node, String text) {
        try {
            return Optional.of(units.computeIfAbsent(text, Unit::parse));
        } catch (IllegalArgumentException notAUnit) {
            return refuse(node, notAUnit.getMessage());
        }
    }

    private static String noNumber(String word, String text, String expected) {
        Matcher joined = NO_SPACE.matcher(word);
        return joined.matches()
                ? "`"
                        + Node.shorten(word)
                        + "` needs a space between number and unit: `"
                        + joined.group("number")
                        + " "
                        + Node.shorten(joined.group("unit"))
                        + "`"
                : "found text `" + Node.shorten(text) + "`, expected " + expected;
    }

    private Optional<double[]> finite(
            Node node, double[] numbers, Unit from, DoubleUnaryOperator conversion) {
        double[] values = Arrays.stream(numbers).map(conversion).toArray();
        for (int i = 0; i < values.length; i++) {
            if (!Double.isFinite(values[i])) {
                return refuse(node, numbers[i] + " " + from + " is too large for a 64-bit number");
            }
        }
        return Optional.of(values);
    }

    private <T> Optional<T> refuse(Node node, String message) {
        problems.add(node, node.label() + ": " + message);
        return Optional.empty();
    }

    private static String expected(int count, Unit unit) {
        return (count == 1 ? "a number" : count + " numbers")
                + (unit.equals(Unit.ONE) ? "" : " in " + unit);
    }

    private static String plural(int count) {
        return count + (count == 1 ? " number" : " numbers");
    }

    private static String example(int count, Unit unit) {
        return "0 ".repeat(count) + (unit.equals(Unit.ONE) ? "deg" : unit.symbol());
    }
}
