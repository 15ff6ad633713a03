// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

/**
 * One parameter of an action. All parameters are required.
 *
 * @param components how many numbers it takes; 1 for anything else
 * @param unit what its numbers are in; {@link Unit#ONE} for anything else
 * @param minimum least number that it takes [unit]; negative infinity for any
 * @param maximum greatest number that it takes [unit]; infinity for any
 */
public record Parameter(
        String name,
        ParameterType type,
        int components,
        Unit unit,
        double minimum,
        double maximum,
        String doc) {
    /** Most numbers in one argument. */
    public static final int MAX_COMPONENTS = 16;

    /** Checks name, components and bounds. */
    public Parameter {
        if (name.isBlank()) {
            throw new IllegalArgumentException("an action's parameter has no name");
        }
        if (components < 1 || components > MAX_COMPONENTS) {
            throw new IllegalArgumentException(
                    "parameter "
                            + name
                            + ": "
                            + components
                            + " components, expected 1 to "
                            + MAX_COMPONENTS);
        }
        if (type != ParameterType.NUMBER
                && (components != 1 || !unit.equals(Unit.ONE) || isBounded(minimum, maximum))) {
            throw new IllegalArgumentException(
                    "parameter " + name + ": only numbers have components, a unit and a range");
        }
        if (!(minimum <= maximum)) {
            throw new IllegalArgumentException(
                    "parameter " + name + ": no number is from " + minimum + " to " + maximum);
        }
    }

    /** A parameter that takes any number, text or truth value. */
    public Parameter(String name, ParameterType type, int components, Unit unit, String doc) {
        this(name, type, components, unit, Double.NEGATIVE_INFINITY, Double.POSITIVE_INFINITY, doc);
    }

    /** This parameter of numbers within a range [unit]; each component has to be in it. */
    public Parameter within(double newMinimum, double newMaximum) {
        return new Parameter(name, type, components, unit, newMinimum, newMaximum, doc);
    }

    /** Whether there is a least or a greatest number. */
    public boolean isBounded() {
        return isBounded(minimum, maximum);
    }

    private static boolean isBounded(double minimum, double maximum) {
        return minimum > Double.NEGATIVE_INFINITY || maximum < Double.POSITIVE_INFINITY;
    }

    /** One or several numbers in a unit. */
    public static Parameter number(String name, int components, Unit unit, String doc) {
        return new Parameter(name, ParameterType.NUMBER, components, unit, doc);
    }

    /** A text. */
    public static Parameter text(String name, String doc) {
        return new Parameter(name, ParameterType.TEXT, 1, Unit.ONE, doc);
    }

    /** True or false. */
    public static Parameter truth(String name, String doc) {
        return new Parameter(name, ParameterType.TRUTH, 1, Unit.ONE, doc);
    }

    /** The name of a body. */
    public static Parameter item(String name, String doc) {
        return new Parameter(name, ParameterType.ITEM, 1, Unit.ONE, doc);
    }

    /** What this parameter takes, in words: {@code 3 numbers in N*s}. */
    String expectation() {
        return switch (type) {
            case NUMBER ->
                    (components == 1 ? "a number" : components + " numbers")
                            + (unit.equals(Unit.ONE) ? "" : " in " + unit.symbol())
                            + range();
            case TEXT -> "a text";
            case TRUTH -> "true or false";
            case ITEM -> "the name of an item";
        };
    }

    private String range() {
        if (!isBounded()) {
            return "";
        }
        return minimum == Double.NEGATIVE_INFINITY
                ? ", at most " + maximum
                : maximum == Double.POSITIVE_INFINITY
                        ? ", at least " + minimum
                        : " from " + minimum + " to " + maximum;
    }
}
