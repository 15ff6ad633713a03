// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/**
 * Limits on the numbers of properties. World files, actions and edits must not set values that no
 * body can have. Actions and edits also must not set magnitudes with which laws cannot compute.
 */
public final class Possible {
    /** Relative tolerance for rounding errors in moments of inertia. */
    private static final double ROUNDING = 1e-6;

    private Possible() {}

    /**
     * Returns the reason why an action or an edit must not set these numbers, for a message; empty
     * if they are allowed.
     */
    public static Optional<String> refusal(PropertyDescriptor property, double... values) {
        if (property.accumulated()) {
            return Optional.of(
                    "it is the sum of what laws add in each step, so it cannot be set; set a"
                            + " property that a law adds to it");
        }
        for (double value : values) {
            Optional<String> refusal = property.type().refusal(value);
            if (refusal.isPresent()) {
                return refusal;
            }
            if (value < property.minimum()) {
                return Optional.of("expected " + property.allowed());
            }
        }
        return isInertia(property) ? impossibleInertia(values) : Optional.empty();
    }

    /**
     * Returns the reason why a body cannot have these principal moments of inertia [kg*m^2]; empty
     * if it can. No moment of a solid exceeds the sum of the other two moments. A moment of 0 means
     * that the body does not rotate about this axis, so the check ignores it.
     */
    public static Optional<String> impossibleInertia(double... moments) {
        for (int axis = 0; axis < 3; axis++) {
            double a = moments[(axis + 1) % 3];
            double b = moments[(axis + 2) % 3];
            if (a > 0 && b > 0 && moments[axis] - a - b > ROUNDING * moments[axis]) {
                return Optional.of(
                        "no body has moments of "
                                + moments[0]
                                + ", "
                                + moments[1]
                                + " and "
                                + moments[2]
                                + " kg*m^2; expected none larger than the sum of the two others");
            }
        }
        return Optional.empty();
    }

    private static boolean isInertia(PropertyDescriptor property) {
        return property.kind().equals(WorldPrototype.BODY) && property.name().equals("inertia");
    }
}
