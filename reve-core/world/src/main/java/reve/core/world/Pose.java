// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * A location [m] and a rotation (unit quaternion xyzw) in the reference frame of the world or of an
 * item. Immutable.
 */
public record Pose(double x, double y, double z, double qx, double qy, double qz, double qw) {

    /** Length of the array form of a pose: location (3), then orientation (4). */
    static final int NUMBERS = 7;

    public static final Pose ORIGIN = new Pose(0, 0, 0, 0, 0, 0, 1);

    /**
     * Checks the numbers.
     *
     * @throws IllegalArgumentException if a number is not finite, or the length of the quaternion
     *     differs from 1 by more than 1e-6
     */
    public Pose {
        double length = Math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw);
        if (!Double.isFinite(x)
                || !Double.isFinite(y)
                || !Double.isFinite(z)
                || !(Math.abs(length - 1) <= 1e-6)) {
            throw new IllegalArgumentException(
                    "pose at "
                            + x
                            + ", "
                            + y
                            + ", "
                            + z
                            + " with orientation "
                            + qx
                            + ", "
                            + qy
                            + ", "
                            + qz
                            + ", "
                            + qw
                            + ": expected finite numbers and a quaternion of length 1");
        }
    }

    /**
     * Returns a pose.
     *
     * @param location (3) [m]
     * @param orientation quaternion xyzw (4) of any length except 0; it is normalised
     */
    public static Pose of(double[] location, double[] orientation) {
        double[] unit = orientation.clone();
        normalise(unit, 0);
        return new Pose(location[0], location[1], location[2], unit[0], unit[1], unit[2], unit[3]);
    }

    /**
     * Returns a pose like {@link #of}. The quaternion must have the length 1 and is stored
     * unchanged.
     */
    static Pose exactly(double[] location, double[] orientation) {
        return new Pose(
                location[0],
                location[1],
                location[2],
                orientation[0],
                orientation[1],
                orientation[2],
                orientation[3]);
    }

    /** Returns the location (3) [m]. */
    public double[] location() {
        return new double[] {x, y, z};
    }

    /** Returns the unit quaternion xyzw (4). */
    public double[] orientation() {
        return new double[] {qx, qy, qz, qw};
    }

    /**
     * Converts this pose, which is relative to {@code outer}, into the reference frame in which
     * {@code outer} is given.
     */
    public Pose within(Pose outer) {
        double[] out = new double[NUMBERS];
        compose(outer.numbers(), 0, numbers(), 0, out, 0);
        return of(out);
    }

    /** Returns this pose relative to {@code outer}. This is the inverse of {@link #within}. */
    public Pose relativeTo(Pose outer) {
        double[] inverse = {0, 0, 0, -outer.qx, -outer.qy, -outer.qz, outer.qw};
        double[] moved = {x - outer.x, y - outer.y, z - outer.z, qx, qy, qz, qw};
        double[] out = new double[NUMBERS];
        compose(inverse, 0, moved, 0, out, 0);
        return of(out);
    }

    static Pose of(double[] numbers) {
        return new Pose(
                numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6]);
    }

    double[] numbers() {
        return new double[] {x, y, z, qx, qy, qz, qw};
    }

    /**
     * Converts a pose relative to {@code outer} into the reference frame of {@code outer}. The
     * array {@code out} may be one of the other two arrays. A vector v rotated by a quaternion with
     * the vector part u and the real part w is v + 2w(u x v) + 2u x (u x v).
     */
    static void compose(
            double[] outer, int at, double[] inner, int innerAt, double[] out, int outAt) {
        double ux = outer[at + 3];
        double uy = outer[at + 4];
        double uz = outer[at + 5];
        double w = outer[at + 6];
        double vx = inner[innerAt];
        double vy = inner[innerAt + 1];
        double vz = inner[innerAt + 2];
        double ix = inner[innerAt + 3];
        double iy = inner[innerAt + 4];
        double iz = inner[innerAt + 5];
        double iw = inner[innerAt + 6];
        double tx = 2 * (uy * vz - uz * vy);
        double ty = 2 * (uz * vx - ux * vz);
        double tz = 2 * (ux * vy - uy * vx);
        out[outAt] = outer[at] + (vx + w * tx + (uy * tz - uz * ty));
        out[outAt + 1] = outer[at + 1] + (vy + w * ty + (uz * tx - ux * tz));
        out[outAt + 2] = outer[at + 2] + (vz + w * tz + (ux * ty - uy * tx));
        out[outAt + 3] = w * ix + ux * iw + (uy * iz - uz * iy);
        out[outAt + 4] = w * iy + uy * iw + (uz * ix - ux * iz);
        out[outAt + 5] = w * iz + uz * iw + (ux * iy - uy * ix);
        out[outAt + 6] = w * iw - (ux * ix + uy * iy + uz * iz);
        normalise(out, outAt + 3);
    }

    /**
     * Normalises a quaternion, because the rounding errors of many multiplications change its
     * length. A quaternion 0 stays 0.
     */
    private static void normalise(double[] values, int at) {
        double length =
                Math.sqrt(
                        values[at] * values[at]
                                + values[at + 1] * values[at + 1]
                                + values[at + 2] * values[at + 2]
                                + values[at + 3] * values[at + 3]);
        if (length > 0) {
            for (int i = at; i < at + 4; i++) {
                values[i] /= length;
            }
        }
    }
}
