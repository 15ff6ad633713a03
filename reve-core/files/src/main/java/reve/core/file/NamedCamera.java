// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.List;
import java.util.Optional;

/**
 * A camera of a world file that commands select by its name. It may be fixed, move along key views,
 * follow an item, or do both. Immutable.
 *
 * @param follow item to whose location eye and target are added; if empty, eye and target are
 *     places in the world
 * @param turning whether eye, target and up also turn with the followed item
 * @param lookAt item at which the camera looks instead of the targets of the keys
 * @param keys key views at increasing times, at least one; a fixed camera has exactly one
 */
public record NamedCamera(
        String name,
        Optional<String> follow,
        boolean turning,
        Optional<String> lookAt,
        List<Key> keys) {

    /**
     * A view at a time.
     *
     * @param timeSeconds world time [s]
     */
    public record Key(double timeSeconds, CameraDescription view) {}

    /** Copies the list. */
    public NamedCamera {
        keys = List.copyOf(keys);
        if (keys.isEmpty()) {
            throw new IllegalArgumentException(
                    "camera " + name + " has no view, expected at least one");
        }
    }

    /**
     * Returns the view at a time. It is the view of a key at the time of this key. A smooth curve
     * passes through the views of all keys. The camera rests before the first key and after the
     * last key. The view ignores {@code follow} and {@code lookAt}.
     *
     * <p>The curve consists of cubic Hermite splines. The slope at a key is the slope of the line
     * between its neighbours, and 0 at both ends.
     */
    public CameraDescription at(double timeSeconds) {
        int next = 0;
        while (next < keys.size() && keys.get(next).timeSeconds() <= timeSeconds) {
            next++;
        }
        if (next == 0 || next == keys.size()) {
            return keys.get(Math.max(0, next - 1)).view();
        }
        Curve curve = new Curve(next - 1, timeSeconds);
        double[] eye = new double[3];
        double[] target = new double[3];
        double[] up = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            int i = axis;
            eye[i] = curve.value(view -> view.eye()[i]);
            target[i] = curve.value(view -> view.target()[i]);
            up[i] = curve.value(view -> view.up()[i]);
        }
        double fov = curve.value(CameraDescription::verticalFovRadians);
        return new CameraDescription(
                eye,
                target,
                up,
                Math.clamp(
                        fov,
                        CameraDescription.NARROWEST_RADIANS,
                        CameraDescription.WIDEST_RADIANS));
    }

    /** One number of a view. */
    private interface Part {
        double of(CameraDescription view);
    }

    /** The curve between two keys, at one time. */
    private final class Curve {
        private final int from;
        private final double span;
        private final double part;

        Curve(int from, double time) {
            this.from = from;
            this.span = time(from + 1) - time(from);
            this.part = (time - time(from)) / span;
        }

        private double time(int key) {
            return keys.get(key).timeSeconds();
        }

        private double value(int key, Part of) {
            return of.of(keys.get(key).view());
        }

        private double slope(int key, Part of) {
            if (key == 0 || key == keys.size() - 1) {
                return 0;
            }
            return (value(key + 1, of) - value(key - 1, of)) / (time(key + 1) - time(key - 1));
        }

        double value(Part of) {
            double s = part;
            double rest = 1 - s;
            return value(from, of) * (1 + 2 * s) * rest * rest
                    + slope(from, of) * span * s * rest * rest
                    + value(from + 1, of) * s * s * (3 - 2 * s)
                    - slope(from + 1, of) * span * s * s * rest;
        }
    }
}
