// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

/**
 * One parameter of an action. All parameters are required.
 *
 * @param components number of numbers that the parameter takes; 1 for other types
 * @param unit unit of these numbers; {@link Unit#ONE} for other types
 * @param minimum smallest accepted number [unit]; negative infinity for no limit
 * @param maximum largest accepted number [unit]; infinity for no limit
 */
public record Parameter(
        String name,
        ParameterType type,
        int components,
        Unit unit,
        double minimum,
        double maximum,
        String doc) {
    /** Maximum number of components of one argument. */
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

    /** Creates a parameter without bounds. */
    public Parameter(String name, ParameterType type, int components, Unit unit, String doc) {
        this(name, type, components, unit, Double.NEGATIVE_INFINITY, Double.POSITIVE_INFINITY, doc);
    }

    /**
     * Returns a copy that accepts only numbers in a range [unit]. Each component must be in the
     * range.
     */
    public Parameter within(double newMinimum, double newMaximum) {
        return new Parameter(name, type, components, unit, newMinimum, newMaximum, doc);
    }

    /** Returns whether the parameter has a minimum or a maximum. */
    public boolean isBounded() {
        return isBounded(minimum, maximum);
    }

    private static boolean isBounded(double minimum, double maximum) {
        return minimum > Double.NEGATIVE_INFINITY || maximum < Double.POSITIVE_INFINITY;
    }

    /** Returns a parameter for one or several numbers in a unit. */
    public static Parameter number(String name, int components, Unit unit, String doc) {
        return new Parameter(name, ParameterType.NUMBER, components, unit, doc);
    }

    /** Returns a parameter for a text. */
    public static Parameter text(String name, String doc) {
        return new Parameter(name, ParameterType.TEXT, 1, Unit.ONE, doc);
    }

    /** Returns a parameter for a truth value. */
    public static Parameter truth(String name, String doc) {
        return new Parameter(name, ParameterType.TRUTH, 1, Unit.ONE, doc);
    }

    /** Returns a parameter for the name of a body. */
    public static Parameter item(String name, String doc) {
        return new Parameter(name, ParameterType.ITEM, 1, Unit.ONE, doc);
    }

    /** Returns the accepted values in words: {@code 3 numbers in N*s}. */
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
