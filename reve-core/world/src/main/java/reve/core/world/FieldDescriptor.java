// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.util.Objects;

/**
 * The declaration of a field, that is, of a function of position, such as the wind. A law library
 * provides the function, and laws evaluate it. Items have no values of it.
 *
 * @param name unique among the properties of a {@link WorldPrototype}
 * @param components numbers of a value: 1 or 3
 * @param unit unit of a value
 */
public record FieldDescriptor(String name, int components, Unit unit, String doc) {

    /** Name of the field that each world has: the force on a body at a position [N]. */
    public static final String FORCE = "forceField";

    /** Checks name and components. */
    public FieldDescriptor {
        Names.requireIdentifier("field name", name);
        Objects.requireNonNull(unit, "unit");
        Objects.requireNonNull(doc, "doc");
        if (components != 1 && components != 3) {
            throw new IllegalArgumentException(
                    "field " + name + ": found " + components + " components, expected 1 or 3");
        }
        if (name.equals(FORCE)) {
            throw new IllegalArgumentException(
                    "field " + name + ": each world has this field without a declaration");
        }
    }
}
