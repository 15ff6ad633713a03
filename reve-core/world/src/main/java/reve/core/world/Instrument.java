// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;

/**
 * Settings of a sensor that measures numbers. Such a sensor senses no items. Its agent receives the
 * numbers with its perceptions, as readings.
 */
public sealed interface Instrument
        permits Instrument.Imu, Instrument.Lidar, Instrument.ContactForce, Instrument.Provided {

    /** Greatest seed of noise. A double can represent all integers from 0 to this number. */
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
     * @param seed seed of the noise, 0 to {@link #GREATEST_SEED}
     */
    record Imu(Errors specificForce, Errors angularVelocity, long seed) implements Instrument {
        /** Checks the seed. */
        public Imu {
            requireSeed(seed);
        }
    }

    /**
     * A lidar at the origin of the body: rays in a fan or a grid around the body's own +Z axis, the
     * front of a glTF model. It measures along each ray the distance to the shapes of other items.
     *
     * @param columns number of rays side by side, from the body's -X to its +X side
     * @param rows number of rays one above the other, from below to above
     * @param width angle between the first and the last column [rad], 0 to 2π; 0 for one column.
     *     With 2π, the columns are spread evenly around the body
     * @param height angle between the first and the last row [rad], 0 to π; 0 for one row
     * @param range maximum distance [m]
     * @param noise standard deviation of each distance [m]
     * @param seed seed of the noise, 0 to {@link #GREATEST_SEED}
     */
    record Lidar(
            int columns,
            int rows,
            double width,
            double height,
            double range,
            double noise,
            long seed)
            implements Instrument {

        /** Maximum number of rays of one lidar. */
        public static final int MAX_RAYS = 4096;

        /** Maximum number of rays in a frame of all lidars that agents of a world may have. */
        public static final int MAX_WORLD_RAYS = 65_536;

        /** Checks the numbers. */
        public Lidar {
            if (columns < 1 || rows < 1 || (long) columns * rows > MAX_RAYS) {
                throw new IllegalArgumentException(
                        "rays: "
                                + (long) columns * rows
                                + " in all rows, expected 1 to "
                                + MAX_RAYS);
            }
            requireAngle("angle", width, Sensor.ALL_ROUND, columns);
            requireAngle("rowAngle", height, Math.PI, rows);
            if (!(range > 0 && Double.isFinite(range))) {
                throw new IllegalArgumentException("range: " + range + " m is not more than 0");
            }
            if (!(noise >= 0 && Double.isFinite(noise))) {
                throw new IllegalArgumentException("noise: " + noise + " m, expected 0 or more");
            }
            requireSeed(seed);
        }

        private static void requireAngle(String key, double angle, double most, int rays) {
            if (!(angle >= 0 && angle <= most) || angle == 0 != (rays == 1)) {
                throw new IllegalArgumentException(
                        key
                                + ": "
                                + Math.toDegrees(angle)
                                + " deg for "
                                + rays
                                + (rays == 1
                                        ? " ray, expected 0"
                                        : " rays, expected more than 0 and at most "
                                                + Math.round(Math.toDegrees(most))
                                                + " deg"));
            }
        }

        /** Returns the number of rays. */
        public int rays() {
            return columns * rows;
        }

        /** Returns the angle of a column from the body's +Z axis towards its +X axis [rad]. */
        public double sideways(int column) {
            int gaps = width < Sensor.ALL_ROUND ? columns - 1 : columns;
            return columns == 1 ? 0 : width * ((double) column / gaps - 0.5);
        }

        /** Returns the angle of a row above the plane of the body's x and z axes [rad]. */
        public double upwards(int row) {
            return rows == 1 ? 0 : height * ((double) row / (rows - 1) - 0.5);
        }
    }

    /**
     * A sensor of the force [N] that other items exert on the body at its contacts: the sum of the
     * properties {@link WorldPrototype#CONTACT_FORCE} and {@link WorldPrototype#REACTION_FORCE},
     * which laws of contact write. The sensor measures the force in the last physics step of the
     * frame.
     *
     * @param ownAxes true to measure in the axes of the body, false to measure in the axes of the
     *     world
     */
    record ContactForce(boolean ownAxes) implements Instrument {}

    /**
     * A sensor whose measurement is written in Java.
     *
     * @param gauge the declaration of the measurement
     * @param quantities the quantities of the gauge
     * @param numbers number of components of all quantities
     */
    record Provided(Gauge gauge, List<Gauge.Quantity> quantities, int numbers)
            implements Instrument {
        /**
         * Reads the quantities of a gauge.
         *
         * @throws IllegalArgumentException if the quantities are impossible
         */
        public static Provided by(Gauge gauge) {
            return new Provided(gauge, List.copyOf(gauge.quantities()), Gauge.numbers(gauge));
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
        /** The value for a measurement without errors. */
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
