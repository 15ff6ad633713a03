// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import reve.core.file.CameraDescription;

/**
 * The viewpoint of a picture.
 *
 * @param eye position of the camera [m]
 * @param target point at the centre of the view [m], different from the eye
 * @param up direction that is up in the picture, not parallel to the line of sight
 * @param orthographic whether lines of sight are parallel
 * @param extent vertical field of view [rad], from 0.001 to 3.1; for an orthographic camera, the
 *     height of the view [m]
 */
public record Camera(Point eye, Point target, Point up, boolean orthographic, double extent) {

    private static final Point UP = new Point(0, 1, 0);

    /**
     * Direction from the target to the eye. It points slightly to the right and upwards, so that
     * the camera shows the front, a side and the top of a box.
     */
    private static final Point THREE_QUARTER = new Point(0.48, 0.42, 1).normalized();

    private static final double FIT_FOV_RADIANS = Math.toRadians(34);

    /** Maximum fraction of the picture's width and height that a fitted box fills. */
    private static final double FIT_FILL = 0.82;

    /**
     * Returns a perspective camera. The angle is the vertical field of view of the picture [rad].
     */
    public static Camera perspective(Point eye, Point target, Point up, double verticalFovRadians) {
        return new Camera(eye, target, up, false, verticalFovRadians);
    }

    /**
     * Returns an orthographic camera. The height is the height of the complete picture in the world
     * [m].
     */
    public static Camera orthographic(Point eye, Point target, Point up, double heightMetres) {
        return new Camera(eye, target, up, true, heightMetres);
    }

    /** Returns the camera of a world file. */
    public static Camera of(CameraDescription description) {
        return perspective(
                point(description.eye()),
                point(description.target()),
                point(description.up()),
                description.verticalFovRadians());
    }

    /**
     * Returns a camera that sees the complete box in a three-quarter view from above. A box without
     * extent is treated as 1 m wide.
     *
     * @param aspect width of the picture divided by its height
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

    /**
     * Returns the length that a pixel shows at the distance of the target, perpendicular to the
     * line of sight [m/px].
     *
     * @param height height of the picture [px]
     */
    public double metresPerPixel(int height) {
        Point sight = target.plus(-1, eye);
        double seen =
                orthographic ? extent : 2 * Math.sqrt(sight.dot(sight)) * Math.tan(extent / 2);
        return seen / height;
    }

    private static Point point(double[] values) {
        return new Point(values[0], values[1], values[2]);
    }
}
