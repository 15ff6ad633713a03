// SPDX-License-Identifier: Apache-2.0
package reve.pe;

/**
 * The scene of the paper's Figure 10. A heavy red body is on a straight line, and a light blue body
 * is in orbit around it on a spring. The red body is the first one.
 */
public final class SpringOrbit {
    /** [kg], (2). */
    public static final double[] MASS = {1000, 1};

    /** [m], (2 x 3). */
    public static final double[] POSITION = {-10, 5, 0, 10, 5, 0};

    /** [m/s], (2 x 3). */
    public static final double[] VELOCITY = {0, 3, 0, 0, 0, 0};

    /** [N/m]. */
    public static final double HOOKE_CONSTANT = 100;

    /** Rest length [m]. */
    public static final double LENGTH = 20;

    /** Laws, in the order of loading. */
    public static final String[] LAWS = {"hooke_spring", "newton_motion"};

    /** Step [s]. */
    public static final double DT = 1.0 / 240;

    /** Number of steps in 5 s. The invariants hold for this time. */
    public static final int STEPS = 1200;

    private SpringOrbit() {}

    /** Quantities of a state that need no integration. */
    public record Invariants(
            double[] momentum, double energyAroundCentre, double distance, double turnedDegrees) {}

    /** Position [m] and velocity [m/s] of the two bodies, (2 x 3) each. */
    public static Invariants invariants(double[] position, double[] velocity) {
        double[] momentum = new double[3];
        double[] apart = new double[3];
        double relativeSpeedSquared = 0;
        for (int i = 0; i < 3; i++) {
            momentum[i] = MASS[0] * velocity[i] + MASS[1] * velocity[3 + i];
            apart[i] = position[3 + i] - position[i];
            double relative = velocity[3 + i] - velocity[i];
            relativeSpeedSquared += relative * relative;
        }
        double distance = Math.hypot(Math.hypot(apart[0], apart[1]), apart[2]);
        double reducedMass = MASS[0] * MASS[1] / (MASS[0] + MASS[1]);
        double stretch = distance - LENGTH;
        return new Invariants(
                momentum,
                0.5 * reducedMass * relativeSpeedSquared + 0.5 * HOOKE_CONSTANT * stretch * stretch,
                distance,
                Math.abs(Math.toDegrees(Math.atan2(apart[1], apart[0]))));
    }
}
