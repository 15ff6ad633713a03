// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Checks of numbers and symbol values before a world stores them. */
final class Values {

    static final int MAX_TEXT = 4096;
    private static final double UNIT_TOLERANCE = 1e-6;

    private Values() {}

    static void requireFinite(String item, String property, double... values) {
        for (double value : values) {
            if (!Double.isFinite(value)) {
                throw new IllegalArgumentException(
                        at(item, property) + "is " + text(values) + ", expected finite numbers");
            }
        }
    }

    /** Returns whether all values are +0, the initial value of columns. */
    static boolean isZero(double... values) {
        for (double value : values) {
            if (Double.doubleToRawLongBits(value) != 0) {
                return false;
            }
        }
        return true;
    }

    /**
     * Checks that values fit a numeric property: their number is right, and each is finite and in
     * the range of the property.
     */
    static void requireFits(String item, PropertyDescriptor property, double... values) {
        String name = property.name();
        if (property.type() == ScalarType.REF) {
            throw new IllegalArgumentException(
                    at(item, name) + "is a reference to another item, not a number");
        }
        if (values.length != property.components()) {
            throw new IllegalArgumentException(
                    at(item, name)
                            + "has "
                            + values.length
                            + " components, expected "
                            + property.components()
                            + " ["
                            + property.unit().symbol()
                            + "]");
        }
        requireFinite(item, name, values);
        for (double value : values) {
            if (!property.type().holds(value)) {
                throw new IllegalArgumentException(
                        at(item, name)
                                + "is "
                                + text(values)
                                + ", which does not fit type "
                                + property.type());
            }
            if (value < property.minimum()) {
                throw new IllegalArgumentException(
                        at(item, name) + "is " + text(values) + ", expected " + property.allowed());
            }
        }
    }

    /**
     * Returns the quaternion normalised to length 1. Returns the same bits if its squared length is
     * 1 within {@link #UNIT_TOLERANCE}, for example after normalisation in 32 bits.
     *
     * @param xyzw four numbers, not all 0
     */
    static double[] requireRotation(String item, double... xyzw) {
        requireFinite(item, "orientation", xyzw);
        double largest = 0;
        for (double value : xyzw) {
            largest = Math.max(largest, Math.abs(value));
        }
        if (largest == 0) {
            throw new IllegalArgumentException(
                    at(item, "orientation")
                            + "is the zero quaternion, expected a rotation such as 0 0 0 1");
        }
        double sum = 0;
        for (double value : xyzw) {
            sum += value / largest * (value / largest);
        }
        if (Math.abs(sum * largest * largest - 1) <= UNIT_TOLERANCE) {
            return xyzw;
        }
        double[] unit = new double[xyzw.length];
        for (int i = 0; i < unit.length; i++) {
            unit[i] = xyzw[i] / largest / Math.sqrt(sum);
        }
        return unit;
    }

    /**
     * Checks that a symbol value is a text, a truth value, a finite number or a list of these, and
     * has the declared type. Returns it in the form in which it is stored, with numbers as Double.
     */
    static Object requireSymbol(
            WorldPrototype prototype, String item, String symbol, Object value) {
        if (symbol.equals(StandardSymbols.CLASSES) && !prototype.classes().isEmpty()) {
            throw new IllegalArgumentException(
                    at(item, symbol) + "is a symbol that the world derives; it cannot be set");
        }
        Object checked = requireSymbol(item, symbol, value);
        misfit(prototype, symbol, checked)
                .ifPresent(
                        misfit -> {
                            throw new IllegalArgumentException(at(item, symbol) + misfit);
                        });
        return checked;
    }

    /** Checks a symbol that items inherit from a class, like {@link #requireSymbol}. */
    static Object requireInheritable(
            WorldPrototype prototype, String itemClass, String symbol, Object value) {
        if (StandardSymbols.DERIVED.contains(symbol)
                || symbol.equals(StandardSymbols.CLASS)
                || symbol.equals(StandardSymbols.CLASSES)) {
            throw new IllegalArgumentException(
                    "class "
                            + itemClass
                            + ": symbol "
                            + symbol
                            + " is a standard one; a class cannot give it");
        }
        Object checked = requireSymbol("of class " + itemClass, symbol, value);
        misfit(prototype, symbol, checked)
                .ifPresent(
                        misfit -> {
                            throw new IllegalArgumentException(
                                    at("of class " + itemClass, symbol) + misfit);
                        });
        return checked;
    }

    /**
     * Returns what is wrong with the type of a symbol; empty if the type is not declared or fits.
     */
    private static Optional<String> misfit(
            WorldPrototype prototype, String symbol, Object checked) {
        return prototype
                .symbol(symbol)
                .filter(declared -> typeOf(checked) != declared.type())
                .map(
                        declared ->
                                "is "
                                        + words(typeOf(checked))
                                        + ", declared as "
                                        + words(declared.type()));
    }

    /**
     * Checks a value like {@link #requireSymbol(WorldPrototype, String, String, Object)}, but
     * permits any type.
     */
    static Object requireSymbol(String item, String symbol, Object value) {
        Names.require("symbol name of item " + item, symbol);
        if (StandardSymbols.DERIVED.contains(symbol)) {
            throw new IllegalArgumentException(
                    at(item, symbol) + "is a symbol that the world derives; it cannot be set");
        }
        if (!(value instanceof List<?> list)) {
            return requireSimple(item, symbol, value);
        }
        if (list.size() > SymbolDescriptor.MAX_ELEMENTS) {
            throw new IllegalArgumentException(
                    at(item, symbol)
                            + "has "
                            + list.size()
                            + " elements, at most "
                            + SymbolDescriptor.MAX_ELEMENTS
                            + " are allowed");
        }
        return list.stream().map(element -> requireSimple(item, symbol, element)).toList();
    }

    private static Object requireSimple(String item, String symbol, Object value) {
        return switch (value) {
            case String text when text.length() > MAX_TEXT ->
                    throw new IllegalArgumentException(
                            at(item, symbol)
                                    + "has "
                                    + text.length()
                                    + " characters, at most "
                                    + MAX_TEXT
                                    + " are allowed");
            case String text when !Names.isUnicode(text) ->
                    throw new IllegalArgumentException(
                            at(item, symbol) + "is no Unicode: it holds half of a surrogate pair");
            case String text -> text;
            case Boolean truth -> truth;
            case Number number -> {
                requireFinite(item, symbol, number.doubleValue());
                yield number.doubleValue();
            }
            default ->
                    throw new IllegalArgumentException(
                            at(item, symbol)
                                    + "is "
                                    + kindOf(value)
                                    + ", expected text, truth, a number or a list of these");
        };
    }

    private static String kindOf(Object value) {
        return switch (value) {
            case List<?> list -> "a list in a list";
            case Map<?, ?> map -> "a map";
            default -> "another kind of value";
        };
    }

    private static SymbolType typeOf(Object symbol) {
        return switch (symbol) {
            case String text -> SymbolType.TEXT;
            case Boolean truth -> SymbolType.TRUTH;
            case List<?> list -> SymbolType.LIST;
            default -> SymbolType.NUMBER;
        };
    }

    private static String words(SymbolType type) {
        return switch (type) {
            case TEXT -> "a text";
            case TRUTH -> "a truth value";
            case LIST -> "a list";
            case NUMBER -> "a number";
        };
    }

    private static String at(String item, String property) {
        return "item " + item + ": " + property + " ";
    }

    private static String text(double[] values) {
        return values.length == 1 ? Double.toString(values[0]) : Arrays.toString(values);
    }
}
