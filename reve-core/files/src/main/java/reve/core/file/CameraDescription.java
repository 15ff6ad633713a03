// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Arrays;

/**
 * The camera from which pictures of a world are drawn.
 *
 * @param eye position of the camera (3) [m]
 * @param target point that it looks at (3) [m], different from the eye
 * @param up direction that is up in the picture (3), not parallel to the line of sight
 * @param verticalFovRadians vertical field of view [rad], {@link #NARROWEST_RADIANS} to {@link
 *     #WIDEST_RADIANS}
 */
public record CameraDescription(
        double[] eye, double[] target, double[] up, double verticalFovRadians) {
    /** Narrowest vertical field of view that a picture can have [rad]. */
    public static final double NARROWEST_RADIANS = Math.toRadians(0.1);

    /** Widest vertical field of view that a picture can have [rad]. */
    public static final double WIDEST_RADIANS = Math.toRadians(175);

    /** Largest coordinate of eye and target [m]; the renderer uses 32-bit numbers. */
    public static final double FARTHEST_METRES = 1e15;

    /**
     * Smallest distance from eye to target, as a fraction of their largest coordinate, so that they
     * differ as 32-bit numbers.
     */
    public static final double NEAREST_TARGET = 1e-6;

    /** Smallest sine of the angle between the line of sight and up. */
    public static final double SMALLEST_TILT = 2e-4;

    /** Copies the arrays. */
    public CameraDescription {
        eye = eye.clone();
        target = target.clone();
        up = up.clone();
    }

    /** Returns a copy of the position (3) [m]. */
    @Override
    public double[] eye() {
        return eye.clone();
    }

    /** Returns a copy of the target (3) [m]. */
    @Override
    public double[] target() {
        return target.clone();
    }

    /** Returns a copy of the up direction (3). */
    @Override
    public double[] up() {
        return up.clone();
    }

    @Override
    public String toString() {
        return "camera at " + Arrays.toString(eye) + " looking at " + Arrays.toString(target);
    }
}
