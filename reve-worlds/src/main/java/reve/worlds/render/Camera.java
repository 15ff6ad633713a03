// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.file.CameraDescription;

/**
 * Where a picture is taken from.
 *
 * @param eye place of the camera [m]
 * @param target what it looks at [m], not the eye
 * @param up the direction that is up in the picture, not along the line of sight
 * @param orthographic whether lines of sight are parallel
 * @param extent vertical field of view [rad], 0.001 to 3.1, or, if orthographic, height of the view
 *     [m]
 */
public record Camera(Point eye, Point target, Point up, boolean orthographic, double extent) {

    private static final Point UP = new Point(0, 1, 0);

    /** From the target to the eye: a little to the right and above, as one looks at a table. */
    private static final Point THREE_QUARTER = new Point(0.48, 0.42, 1).normalized();

    private static final double FIT_FOV_RADIANS = Math.toRadians(34);

    /** Part of the picture's width and height that a fitted box may take up. */
    private static final double FIT_FILL = 0.82;

    public static Camera perspective(Point eye, Point target, Point up, double verticalFovRadians) {
        return new Camera(eye, target, up, false, verticalFovRadians);
    }

    public static Camera orthographic(Point eye, Point target, Point up, double heightMetres) {
        return new Camera(eye, target, up, true, heightMetres);
    }

    /** The camera of a world file. */
    public static Camera of(CameraDescription description) {
        return perspective(
                point(description.eye()),
                point(description.target()),
                point(description.up()),
                description.verticalFovRadians());
    }

    /**
     * Sees the whole box, well filled, in a three-quarter view from above. A point is shown as if
     * it were 1 m wide.
     *
     * @param aspect width of the picture by its height
     */
    public static Camera fit(Bounds bounds, double aspect) {
        if (!(aspect > 0 && aspect < 1e4)) {
            throw new IllegalArgumentException(
                    "aspect " + aspect + ", expected above 0 and below 1e4");
        }
        Point centre = bounds.centre();
        Point right = UP.cross(THREE_QUARTER).normalized();
        Point up = THREE_QUARTER.cross(right);
        double slope = Math.tan(FIT_FOV_RADIANS / 2) * FIT_FILL;
        double distance = bounds.longestSide() > 0 ? 0 : 0.5 / slope;
        for (int i = 0; i < 8; i++) {
            Point corner = bounds.corner(i).plus(-1, centre);
            double nearer = corner.dot(THREE_QUARTER);
            distance = Math.max(distance, nearer + Math.abs(corner.dot(right)) / (slope * aspect));
            distance = Math.max(distance, nearer + Math.abs(corner.dot(up)) / slope);
        }
        return perspective(centre.plus(distance, THREE_QUARTER), centre, UP, FIT_FOV_RADIANS);
    }

    private static Point point(double[] values) {
        return new Point(values[0], values[1], values[2]);
    }
}
