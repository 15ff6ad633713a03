package reve.core.world;

import reve.core.unit.Unit;

/**
 * One parameter of an action. All parameters are required.
 *
 * @param components how many numbers it takes; 1 for texts and truth values
 * @param unit what its numbers are in; {@link Unit#ONE} for texts and truth values
 */
public record Parameter(String name, ParameterType type, int components, Unit unit, String doc) {
    /** Most numbers in one argument. */
    public static final int MAX_COMPONENTS = 16;

    public Parameter {
        if (name.isBlank()) {
            throw new IllegalArgumentException("an action's parameter has no name");
        }
        if (components < 1 || components > MAX_COMPONENTS) {
            throw new IllegalArgumentException("parameter " + name + ": " + components
                    + " components, expected 1 to " + MAX_COMPONENTS);
        }
        if (type != ParameterType.NUMBER && (components != 1 || !unit.equals(Unit.ONE))) {
            throw new IllegalArgumentException("parameter " + name
                    + ": only numbers have components and a unit");
        }
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

    /** What this parameter takes, in words: {@code 3 numbers in N*s}. */
    String expectation() {
        return switch (type) {
            case NUMBER -> (components == 1 ? "a number" : components + " numbers")
                    + (unit.equals(Unit.ONE) ? "" : " in " + unit.symbol());
            case TEXT -> "a text";
            case TRUTH -> "true or false";
        };
    }
}
