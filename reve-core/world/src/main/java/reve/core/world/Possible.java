// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/**
 * Limits on the numbers of properties. Values that no body can have are refused in world files,
 * actions and edits; magnitudes that laws cannot compute with are refused in actions and edits.
 */
public final class Possible {
    /** Relative tolerance for rounding of moments. */
    private static final double ROUNDING = 1e-6;

    private Possible() {}

    /** Returns why an action or an edit may not set these numbers; empty if it may. */
    public static Optional<String> refusal(PropertyDescriptor property, double... values) {
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
     * Returns why a body cannot have these principal moments [kg*m^2]; empty if it can. For a
     * solid, none exceeds the sum of the two others; an axis of 0 is locked.
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
