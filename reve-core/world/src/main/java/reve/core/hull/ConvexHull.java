// SPDX-License-Identifier: Apache-2.0
package reve.core.hull;

import java.util.Arrays;
import java.util.List;
import java.util.Locale;

/**
 * The smallest convex polyhedron around points, whose faces may have any number of corners. The
 * hull also has a core, which is the same polyhedron with all faces moved inwards. Immutable.
 * Callers must not change the returned arrays.
 *
 * <p>A hull has at most {@link #MAX_CORNERS} corners. If more points would become corners, the hull
 * uses the outermost points and ignores the others.
 */
public final class ConvexHull {
    /** Maximum number of corners. */
    public static final int MAX_CORNERS = 128;

    /**
     * Distance by which the faces of the core are moved inwards, as a fraction of {@link
     * #thickness()}.
     */
    public static final double ROUNDING = 0.05;

    /** Minimum thickness of a hull, as a fraction of its largest extent along an axis. */
    public static final double LEAST_THICKNESS = 1e-3;

    /**
     * Maximum distance of a corner from the plane of its face, as a fraction of the largest extent.
     */
    private static final double FLAT = 1e-5;

    private final double[] corners;
    private final int[][] faces;
    private final double[] normals;
    private final double[] offsets;
    private final double[] centre;
    private final double volume;
    private final double thickness;
    private final double[] core;

    private ConvexHull(double[] corners, int[][] faces, double extent) {
        this.corners = corners;
        this.faces = faces;
        normals = new double[3 * faces.length];
        offsets = new double[faces.length];
        thickness = faces.length < 4 ? 0 : planes();
        if (!(thickness >= LEAST_THICKNESS * extent)) {
            throw new IllegalArgumentException(
                    String.format(
                            Locale.ROOT,
                            "its convex hull is %.3g m thick and %.3g m long, expected a thickness"
                                    + " of at least 1/%.0f of the length",
                            thickness,
                            extent,
                            1 / LEAST_THICKNESS));
        }
        centre = new double[3];
        volume = centroid();
        core = new Core(this, ROUNDING * thickness, extent).corners();
    }

    /**
     * Computes the hull of points.
     *
     * @param points (count x 3) coordinates [m], finite
     * @throws IllegalArgumentException if the points enclose no volume, or the hull is too thin;
     *     the message completes the text "the mesh: "
     */
    public static ConvexHull of(double[] points) {
        double[] low = new double[3];
        double[] high = new double[3];
        Arrays.fill(low, Double.POSITIVE_INFINITY);
        Arrays.fill(high, Double.NEGATIVE_INFINITY);
        for (int i = 0; i < points.length; i++) {
            low[i % 3] = Math.min(low[i % 3], points[i]);
            high[i % 3] = Math.max(high[i % 3], points[i]);
        }
        double extent = 0;
        for (int axis = 0; axis < 3; axis++) {
            extent = Math.max(extent, high[axis] - low[axis]);
        }
        List<int[]> triangles;
        try {
            triangles = ExactHull.of(grid(points, low, high), MAX_CORNERS);
        } catch (IllegalArgumentException flat) {
            throw new IllegalArgumentException(
                    "its " + points.length / 3 + " vertices " + flat.getMessage());
        }
        return new Merging(points, triangles, FLAT * extent).hull(extent);
    }

    /**
     * Returns the points with integer coordinates. Along each axis, the grid divides the extent of
     * the points into {@link ExactHull#LARGEST} equal intervals.
     */
    static long[] grid(double[] points, double[] low, double[] high) {
        long[] grid = new long[points.length];
        for (int i = 0; i < points.length; i++) {
            double range = high[i % 3] - low[i % 3];
            double place = range > 0 ? (points[i] - low[i % 3]) / range : 0;
            grid[i] = (long) Math.rint(place * ExactHull.LARGEST);
        }
        return grid;
    }

    static ConvexHull of(double[] corners, int[][] faces, double extent) {
        return new ConvexHull(corners, faces, extent);
    }

    /** Returns (count x 3) coordinates of the corners [m]. */
    public double[] corners() {
        return corners;
    }

    /** Returns the indices of the corners of each face, counter-clockwise as seen from outside. */
    public int[][] faces() {
        return faces;
    }

    /** Returns (count x 3) coordinates of the corners of the core [m]. */
    public double[] core() {
        return core;
    }

    /** Returns the centre of the volume (3) [m]. */
    public double[] centre() {
        return centre;
    }

    /** Returns the volume [m^3]. */
    public double volume() {
        return volume;
    }

    /** Returns the smallest extent perpendicular to a face [m]. */
    public double thickness() {
        return thickness;
    }

    /** Returns one component of the outward unit normal of a face. */
    double normal(int face, int axis) {
        return normals[3 * face + axis];
    }

    /** Returns the distance of a face's plane from the origin along its normal [m]. */
    double offset(int face) {
        return offsets[face];
    }

    /** Returns the triangles of the faces, three corners each. */
    public int[] triangles() {
        int[] triangles = new int[3 * Arrays.stream(faces).mapToInt(face -> face.length - 2).sum()];
        int next = 0;
        for (int[] face : faces) {
            for (int i = 2; i < face.length; i++) {
                triangles[next++] = face[0];
                triangles[next++] = face[i - 1];
                triangles[next++] = face[i];
            }
        }
        return triangles;
    }

    /** Computes the planes of the faces, and returns the thickness. */
    private double planes() {
        double least = Double.POSITIVE_INFINITY;
        for (int face = 0; face < faces.length; face++) {
            double[] normal = normalOf(corners, faces[face]);
            System.arraycopy(normal, 0, normals, 3 * face, 3);
            double low = Double.POSITIVE_INFINITY;
            double high = Double.NEGATIVE_INFINITY;
            for (int i = 0; i < corners.length; i += 3) {
                double along =
                        normal[0] * corners[i]
                                + normal[1] * corners[i + 1]
                                + normal[2] * corners[i + 2];
                low = Math.min(low, along);
                high = Math.max(high, along);
            }
            offsets[face] = high;
            least = Math.min(least, high - low);
        }
        return least;
    }

    /** Returns the unit normal of a polygon, by Newell's method (M. E. Newell). */
    static double[] normalOf(double[] corners, int[] face) {
        double[] sum = new double[3];
        for (int i = 0; i < face.length; i++) {
            int p = 3 * face[i];
            int q = 3 * face[(i + 1) % face.length];
            int first = 3 * face[0];
            for (int axis = 0; axis < 3; axis++) {
                int u = (axis + 1) % 3;
                int v = (axis + 2) % 3;
                sum[axis] +=
                        (corners[p + u] - corners[first + u])
                                        * (corners[q + v] - corners[first + v])
                                - (corners[p + v] - corners[first + v])
                                        * (corners[q + u] - corners[first + u]);
            }
        }
        double length = Math.sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
        for (int axis = 0; axis < 3 && length > 0; axis++) {
            sum[axis] /= length;
        }
        return sum;
    }

    /**
     * Computes the centre and returns the volume. Divides the hull into tetrahedra that meet at one
     * corner.
     */
    private double centroid() {
        double sum = 0;
        int[] triangles = triangles();
        double[][] edge = new double[3][3];
        for (int i = 0; i < triangles.length; i += 3) {
            for (int j = 0; j < 3; j++) {
                for (int axis = 0; axis < 3; axis++) {
                    edge[j][axis] = corners[3 * triangles[i + j] + axis] - corners[axis];
                }
            }
            double part =
                    (edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1])
                                    + edge[0][1]
                                            * (edge[1][2] * edge[2][0] - edge[1][0] * edge[2][2])
                                    + edge[0][2]
                                            * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]))
                            / 6;
            sum += part;
            for (int axis = 0; axis < 3; axis++) {
                centre[axis] += part * (edge[0][axis] + edge[1][axis] + edge[2][axis]) / 4;
            }
        }
        for (int axis = 0; axis < 3; axis++) {
            centre[axis] = corners[axis] + centre[axis] / sum;
        }
        return sum;
    }
}
