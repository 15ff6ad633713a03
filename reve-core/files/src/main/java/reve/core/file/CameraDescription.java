// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Arrays;

/**
 * The camera from which pictures of a world are drawn.
 *
 * @param eye position of the camera (3) [m]
 * @param target point at which the camera looks (3) [m], different from the eye
 * @param up direction that is up in the picture (3), not parallel to the line of sight
 * @param verticalFovRadians vertical field of view [rad], {@link #NARROWEST_RADIANS} to {@link
 *     #WIDEST_RADIANS}
 */
public record CameraDescription(
        double[] eye, double[] target, double[] up, double verticalFovRadians) {
    /** Minimum vertical field of view of a picture [rad]. */
    public static final double NARROWEST_RADIANS = Math.toRadians(0.1);

    /** Maximum vertical field of view of a picture [rad]. */
    public static final double WIDEST_RADIANS = Math.toRadians(175);

    /**
     * Maximum coordinate of eye and target [m]. The limit exists because the renderer uses 32-bit
     * numbers.
     */
    public static final double FARTHEST_METRES = 1e15;

    /**
     * Minimum distance from eye to target, as a fraction of their largest coordinate. At this
     * distance, the two points still differ as 32-bit numbers.
     */
    public static final double NEAREST_TARGET = 1e-6;

    /** Minimum sine of the angle between the line of sight and {@code up}. */
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
