// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Arrays;

/**
 * Where pictures of a world are taken from.
 *
 * @param eye place of the camera (3) [m]
 * @param target what it looks at (3) [m], not the eye
 * @param up the direction that is up in the picture (3), not along the line of sight
 * @param verticalFovRadians opening angle from bottom to top, above 0 and below pi
 */
public record CameraDescription(
        double[] eye, double[] target, double[] up, double verticalFovRadians) {
    public CameraDescription {
        eye = eye.clone();
        target = target.clone();
        up = up.clone();
    }

    @Override
    public double[] eye() {
        return eye.clone();
    }

    @Override
    public double[] target() {
        return target.clone();
    }

    @Override
    public double[] up() {
        return up.clone();
    }

    @Override
    public String toString() {
        return "camera at " + Arrays.toString(eye) + " looking at " + Arrays.toString(target);
    }
}
