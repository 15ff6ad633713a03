// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Optional;

/**
 * The place of a group of items in the reference frame that contains the group: a rotation, and
 * then a translation. Immutable.
 *
 * @param location location of the group's origin [m], (3)
 * @param orientation rotation of the group, a unit quaternion xyzw, (4); empty for no rotation, so
 *     that numbers keep all of their bits
 */
record Placement(double[] location, Optional<double[]> orientation) {
    /** The place of items that belong to no group. */
    static final Placement NONE = new Placement(new double[3], Optional.empty());

    /** Properties of bodies that are vectors along the axes of the reference frame. */
    private static final List<String> VECTORS =
            List.of(
                    "velocity",
                    "acceleration",
                    "externalForce",
                    "appliedForce",
                    "angularVelocity",
                    "torque");

    /** Returns the placement of an item as a group. */
    static Placement of(ItemDefinition group) {
        double[] turn = group.orientation();
        boolean turned = turn[0] != 0 || turn[1] != 0 || turn[2] != 0;
        return new Placement(group.location(), turned ? Optional.of(turn) : Optional.empty());
    }

    /** Returns the placement of a group that is a part of this group. */
    Placement of(Placement part) {
        return new Placement(moved(part.location), turned(part.orientation));
    }

    /**
     * Returns an item of the group at its place in the outer reference frame. Does not change an
     * item without a place of its own: an item of another kind than body, or an attached item.
     */
    ItemDefinition placed(ItemDefinition part) {
        if (this == NONE || !part.kind().equals(WorldPrototype.BODY) || part.parent().isPresent()) {
            return part;
        }
        double[] at = moved(part.location());
        ItemDefinition.Builder placed = part.copy(part.name()).at(at[0], at[1], at[2]);
        if (orientation.isPresent()) {
            double[] turn = product(orientation.get(), part.orientation());
            placed.orientation(turn[0], turn[1], turn[2], turn[3]);
            for (String property : VECTORS) {
                part.physics(property)
                        .ifPresent(
                                vector ->
                                        placed.physics(
                                                property, rotated(orientation.get(), vector)));
            }
        }
        return placed.build();
    }

    private double[] moved(double[] point) {
        double[] turned = orientation.map(turn -> rotated(turn, point)).orElse(point);
        return new double[] {
            location[0] + turned[0], location[1] + turned[1], location[2] + turned[2]
        };
    }

    private Optional<double[]> turned(Optional<double[]> inner) {
        return orientation.isEmpty()
                ? inner
                : Optional.of(
                        inner.map(turn -> product(orientation.get(), turn))
                                .orElse(orientation.get()));
    }

    /** Returns the quaternion of the rotation b followed by the rotation a. */
    private static double[] product(double[] a, double[] b) {
        return new double[] {
            a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
            a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
            a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
            a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
        };
    }

    /**
     * Returns a vector v rotated by a unit quaternion with the vector part q and the real part w: v
     * + 2 w (q x v) + 2 q x (q x v).
     */
    private static double[] rotated(double[] q, double[] v) {
        double[] t = cross(q, v);
        double[] u = cross(q, t);
        double[] result = new double[3];
        for (int i = 0; i < 3; i++) {
            result[i] = v[i] + 2 * (q[3] * t[i] + u[i]);
        }
        return result;
    }

    private static double[] cross(double[] a, double[] b) {
        return new double[] {
            a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        };
    }
}
