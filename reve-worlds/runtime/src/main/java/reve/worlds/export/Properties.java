// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import reve.core.world.Colour;
import reve.core.world.ColumnView;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** Names and values of properties in exported files. */
final class Properties {
    private static final String SHAPE = "shape";
    private static final String COLOUR = "colour";
    private static final Map<Integer, List<String>> AXES =
            Map.of(1, List.of(""), 3, List.of("x", "y", "z"), 4, List.of("x", "y", "z", "w"));

    private Properties() {}

    /**
     * Returns the names of a property's components. Vectors and quaternions have x, y, z and w.
     * References and other lists have numbers from 0. A single number has an empty text.
     */
    static List<String> components(PropertyDescriptor property) {
        if (property.components() > 1 && property.type() == ScalarType.REF) {
            return numbers(property.components());
        }
        List<String> axes = AXES.get(property.components());
        return axes == null ? numbers(property.components()) : axes;
    }

    private static List<String> numbers(int count) {
        List<String> numbers = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            numbers.add(Integer.toString(i));
        }
        return numbers;
    }

    /**
     * Returns whether the values are written as texts. References, shapes and colours are written
     * in this way.
     */
    static boolean isText(PropertyDescriptor property) {
        return property.type() == ScalarType.REF || isLook(property);
    }

    private static boolean isLook(PropertyDescriptor property) {
        return property.kind().equals(WorldPrototype.BODY)
                && (property.name().equals(SHAPE) || property.name().equals(COLOUR));
    }

    /** Returns the value of a property for which {@link #isText} is true. */
    static String text(ColumnView column, int row, int component, WorldSnapshot snapshot) {
        if (column.type() == ScalarType.REF) {
            long id = column.getReference(row, component);
            ItemSymbols item = id == 0 ? null : snapshot.symbols().get(new ItemId(id));
            return item == null ? "" : item.name();
        }
        int code = column.getInt(row, component);
        return column.name().equals(COLOUR) ? new Colour(code).toString() : shape(code);
    }

    private static String shape(int code) {
        return switch (code) {
            case Shape.NONE -> "none";
            case Shape.SPHERE -> "sphere";
            case Shape.BOX -> "box";
            case Shape.PLANE -> "plane";
            case Shape.MESH -> "mesh";
            case Shape.CAPSULE -> "capsule";
            case Shape.CYLINDER -> "cylinder";
            case Shape.ELLIPSOID -> "ellipsoid";
            default -> Integer.toString(code);
        };
    }

    /**
     * Returns a number with all its digits. A reader that parses the text in the precision of the
     * column gets the same bits.
     */
    static String number(ColumnView column, int row, int component) {
        double value = column.getDouble(row, component);
        return switch (column.type()) {
            case F64 -> Double.toString(value);
            case F32 -> Float.toString((float) value);
            case I32, U32, REF -> Long.toString((long) value);
        };
    }
}
