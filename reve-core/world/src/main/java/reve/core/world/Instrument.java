// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * Settings of a sensor that measures numbers. Such a sensor senses no items. Its agent receives the
 * numbers with its perceptions, as readings.
 */
public sealed interface Instrument permits Instrument.Imu {

    /** Greatest seed of noise, the greatest integer that a double represents with all below it. */
    long GREATEST_SEED = (1L << 53) - 1;

    /**
     * An inertial measurement unit at the origin of the body. It measures in the body's own axes:
     *
     * <ul>
     *   <li>the specific force [m/s²]: the mean acceleration during the frame minus the
     *       acceleration of gravity, see {@link WorldPrototype#SPECIFIC_FORCE}
     *   <li>the angular velocity [rad/s] at the end of the frame, see {@link
     *       WorldPrototype#ANGULAR_RATE}
     * </ul>
     *
     * @param specificForce errors of the specific force [m/s²]
     * @param angularVelocity errors of the angular velocity [rad/s]
     * @param seed of the noise, 0 to {@link #GREATEST_SEED}
     */
    record Imu(Errors specificForce, Errors angularVelocity, long seed) implements Instrument {
        /** Checks the seed. */
        public Imu {
            requireSeed(seed);
        }
    }

    /**
     * The errors of a measured vector, in the unit of the vector. Noise is normally distributed and
     * independent in each component of each measurement. It depends only on the seed, the item, the
     * sensor and the time of the world.
     *
     * @param noise standard deviation of each component, 0 or more
     * @param biasX constant error along the body's own x axis
     * @param biasY constant error along the y axis
     * @param biasZ constant error along the z axis
     */
    record Errors(double noise, double biasX, double biasY, double biasZ) {
        /** No errors. */
        public static final Errors NONE = new Errors(0, 0, 0, 0);

        /** Checks the numbers. */
        public Errors {
            if (!(noise >= 0 && Double.isFinite(noise))) {
                throw new IllegalArgumentException("noise: " + noise + ", expected 0 or more");
            }
            if (!Double.isFinite(biasX) || !Double.isFinite(biasY) || !Double.isFinite(biasZ)) {
                throw new IllegalArgumentException("bias: not a finite number");
            }
        }

        /** Returns the constant error along an axis (0, 1, 2). */
        public double bias(int axis) {
            return axis == 0 ? biasX : axis == 1 ? biasY : biasZ;
        }
    }

    private static void requireSeed(long seed) {
        if (seed < 0 || seed > GREATEST_SEED) {
            throw new IllegalArgumentException(
                    "seed: " + seed + ", expected 0 to " + GREATEST_SEED);
        }
    }
}
