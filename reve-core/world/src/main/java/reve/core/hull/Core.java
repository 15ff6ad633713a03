// SPDX-License-Identifier: Apache-2.0
package reve.core.hull;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/**
 * The polyhedron inside a hull whose faces are moved inwards. Each face corresponds to a dual
 * point, which is the normal of the face divided by the distance of the face from the centre. Each
 * triangle of the hull of these dual points corresponds to a corner of the polyhedron.
 */
final class Core {
    private static final double LEAST_DETERMINANT = 1e-9;

    private final ConvexHull hull;
    private final double rounding;
    private final double tolerance;
    private final int count;
    private final double[] distances;

    /**
     * @param rounding distance by which the faces are moved [m]
     */
    Core(ConvexHull hull, double rounding, double extent) {
        this.hull = hull;
        this.rounding = rounding;
        tolerance = 1e-7 * extent;
        count = hull.faces().length;
        distances = new double[count];
        for (int face = 0; face < count; face++) {
            double toCentre = 0;
            for (int axis = 0; axis < 3; axis++) {
                toCentre += hull.normal(face, axis) * hull.centre()[axis];
            }
            distances[face] = hull.offset(face) - toCentre;
        }
    }

    /** Returns (count x 3) coordinates of the corners [m]. */
    double[] corners() {
        List<double[]> found = new ArrayList<>();
        for (int[] faces : dual()) {
            double[] corner = meeting(faces[0], faces[1], faces[2]);
            if (corner.length == 3 && isInside(corner) && isNew(corner, found)) {
                found.add(corner);
            }
        }
        if (found.size() < 4) {
            return shrunk();
        }
        double[] corners = new double[3 * found.size()];
        for (int i = 0; i < found.size(); i++) {
            for (int axis = 0; axis < 3; axis++) {
                corners[3 * i + axis] = hull.centre()[axis] + found.get(i)[axis];
            }
        }
        return corners;
    }

    /** Returns the triples of faces that may meet at a corner of the core. */
    private List<int[]> dual() {
        double[] points = new double[3 * count];
        double[] low = new double[3];
        double[] high = new double[3];
        for (int i = 0; i < points.length; i++) {
            points[i] = hull.normal(i / 3, i % 3) / (distances[i / 3] - rounding);
            low[i % 3] = Math.min(low[i % 3], points[i]);
            high[i % 3] = Math.max(high[i % 3], points[i]);
        }
        try {
            return ExactHull.of(ConvexHull.grid(points, low, high), Integer.MAX_VALUE);
        } catch (IllegalArgumentException flat) {
            return List.of();
        }
    }

    /** Returns the point at which the planes of three faces meet; empty if there is none. */
    private double[] meeting(int... faces) {
        double[][] m = new double[3][4];
        for (int i = 0; i < 3; i++) {
            for (int axis = 0; axis < 3; axis++) {
                m[i][axis] = hull.normal(faces[i], axis);
            }
            m[i][3] = distances[faces[i]] - rounding;
        }
        double determinant = determinant(m, 0, 1, 2);
        return Math.abs(determinant) < LEAST_DETERMINANT
                ? new double[0]
                : new double[] {
                    determinant(m, 3, 1, 2) / determinant,
                    determinant(m, 0, 3, 2) / determinant,
                    determinant(m, 0, 1, 3) / determinant
                };
    }

    private static double determinant(double[][] m, int a, int b, int c) {
        return m[0][a] * (m[1][b] * m[2][c] - m[1][c] * m[2][b])
                + m[1][a] * (m[2][b] * m[0][c] - m[2][c] * m[0][b])
                + m[2][a] * (m[0][b] * m[1][c] - m[0][c] * m[1][b]);
    }

    private boolean isInside(double[] corner) {
        for (int face = 0; face < count; face++) {
            double along = 0;
            for (int axis = 0; axis < 3; axis++) {
                along += hull.normal(face, axis) * corner[axis];
            }
            if (!(along <= distances[face] - rounding + tolerance)) {
                return false;
            }
        }
        return true;
    }

    private boolean isNew(double[] corner, List<double[]> found) {
        return found.stream()
                .noneMatch(
                        other ->
                                Math.abs(other[0] - corner[0])
                                                + Math.abs(other[1] - corner[1])
                                                + Math.abs(other[2] - corner[2])
                                        < tolerance);
    }

    /**
     * Returns the corners of the hull, scaled towards the centre. The scale is chosen so that every
     * face moves inwards by at least {@link #rounding}.
     */
    private double[] shrunk() {
        double scale = 1 - rounding / Arrays.stream(distances).min().orElseThrow();
        double[] corners = hull.corners().clone();
        for (int i = 0; i < corners.length; i++) {
            double centre = hull.centre()[i % 3];
            corners[i] = centre + scale * (corners[i] - centre);
        }
        return corners;
    }
}
