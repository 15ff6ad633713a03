// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.util.Objects;
import java.util.Optional;

/**
 * The declaration of a property, that is, of one typed column for all items of a kind.
 *
 * @param name unique within a {@link WorldPrototype}
 * @param kind the kind of the items that have the property, for example {@code body}
 * @param components numbers per item, 1 to 16
 * @param refersTo the kind of items to which a {@link ScalarType#REF} property refers; empty for
 *     numbers
 * @param minimum smallest number that may be set [unit]; negative infinity for no limit
 * @param accumulated whether the engine sets the numbers to 0 in each step and sums what laws add.
 *     Actions, edits and world files do not set such a property
 */
public record PropertyDescriptor(
        String name,
        String kind,
        ScalarType type,
        int components,
        Unit unit,
        Optional<String> refersTo,
        double minimum,
        boolean accumulated,
        String doc) {

    /** Maximum number of components, which is the size of a 4 by 4 matrix. */
    public static final int MAX_COMPONENTS = 16;

    /** Checks names, components and bounds. */
    public PropertyDescriptor {
        Names.requireIdentifier("property name", name);
        Names.requireIdentifier("kind of property " + name, kind);
        Objects.requireNonNull(type, "type");
        Objects.requireNonNull(unit, "unit");
        Objects.requireNonNull(doc, "doc");
        if (components < 1 || components > MAX_COMPONENTS) {
            throw new IllegalArgumentException(
                    "property "
                            + name
                            + ": "
                            + components
                            + " components, expected 1 to "
                            + MAX_COMPONENTS);
        }
        if (refersTo.isPresent() != (type == ScalarType.REF)) {
            throw new IllegalArgumentException(
                    "property "
                            + name
                            + ": a reference names the kind it refers to, and only a reference"
                            + " does; found type "
                            + type
                            + ", refers to "
                            + refersTo.orElse("nothing"));
        }
        if (Double.isNaN(minimum) || minimum == Double.POSITIVE_INFINITY) {
            throw new IllegalArgumentException(
                    "property "
                            + name
                            + ": its least value is "
                            + minimum
                            + ", expected a finite number");
        }
        if (minimum != Double.NEGATIVE_INFINITY && type == ScalarType.REF) {
            throw new IllegalArgumentException(
                    "property " + name + ": a reference has no least value");
        }
        if (accumulated
                && (type != ScalarType.F32 && type != ScalarType.F64
                        || minimum != Double.NEGATIVE_INFINITY)) {
            throw new IllegalArgumentException(
                    "property "
                            + name
                            + ": only a real number without a least value is a sum of what laws"
                            + " add");
        }
    }

    /** Creates a property that is no sum of what laws add. */
    public PropertyDescriptor(
            String name,
            String kind,
            ScalarType type,
            int components,
            Unit unit,
            Optional<String> refersTo,
            double minimum,
            String doc) {
        this(name, kind, type, components, unit, refersTo, minimum, false, doc);
    }

    /** Creates a property whose only limits are those of its type. */
    public PropertyDescriptor(
            String name,
            String kind,
            ScalarType type,
            int components,
            Unit unit,
            Optional<String> refersTo,
            String doc) {
        this(name, kind, type, components, unit, refersTo, Double.NEGATIVE_INFINITY, doc);
    }

    /** Returns the range of allowed numbers in words, for messages about a value outside it. */
    public String allowed() {
        return (minimum == 0 ? "0" : Double.toString(minimum)) + " or more [" + unit.symbol() + "]";
    }

    /** Returns the size of one row [bytes]. */
    public int rowBytes() {
        return type.bytes() * components;
    }
}
