// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Arrays;

/**
 * The viewpoint of a world's pictures.
 *
 * @param eye position of the camera (3) [m]
 * @param target point that it looks at (3) [m], different from the eye
 * @param up direction that is up in the picture (3), not parallel to the line of sight
 * @param verticalFovRadians vertical field of view [rad], above 0 and below pi
 */
public record CameraDescription(
        double[] eye, double[] target, double[] up, double verticalFovRadians) {
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
