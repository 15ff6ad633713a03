// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.util.Objects;
import java.util.Optional;

/**
 * What a property is: one typed column of every item of a kind.
 *
 * @param name unique within a {@link WorldPrototype}
 * @param kind the row space the property belongs to: {@code body}, {@code spring}, ...
 * @param components numbers per item, 1 to 16
 * @param refersTo the kind that a {@link ScalarType#REF} property points at; empty for numbers
 * @param minimum least value that a number may be given [unit]; negative infinity for any
 */
public record PropertyDescriptor(
        String name,
        String kind,
        ScalarType type,
        int components,
        Unit unit,
        Optional<String> refersTo,
        double minimum,
        String doc) {

    /** Most numbers one item may have in one property: a 4 by 4 matrix. */
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
    }

    /** A property whose numbers may be any that its type holds. */
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

    /** What a number may be that the property refuses although its type holds it; for messages. */
    public String allowed() {
        return (minimum == 0 ? "0" : Double.toString(minimum)) + " or more [" + unit.symbol() + "]";
    }

    /** Bytes of one row. */
    public int rowBytes() {
        return type.bytes() * components;
    }
}
