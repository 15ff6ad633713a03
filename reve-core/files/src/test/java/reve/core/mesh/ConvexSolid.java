// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Mesh;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.List;
import java.util.Random;

/** The convex hull of random points as a mesh. Its integrals are computed from slices. */
final class ConvexSolid {

    /** Nodes and weights of Gauss and Legendre on -1 to 1, exact for polynomials of degree 5. */
    private static final double[] NODES = {-Math.sqrt(0.6), 0, Math.sqrt(0.6)};

    private static final double[] WEIGHTS = {5.0 / 9, 8.0 / 9, 5.0 / 9};

    private final double[][] points;
    private final List<int[]> faces = new ArrayList<>();

    /** Points in a box of random sides around a random place, in general position. */
    ConvexSolid(Random random, int count) {
        double[] place = random.doubles(3, -5, 5).toArray();
        double[] sides = random.doubles(3, 0.1, 3).toArray();
        points = new double[count][3];
        for (double[] point : points) {
            for (int axis = 0; axis < 3; axis++) {
                point[axis] = (float) (place[axis] + sides[axis] * random.nextDouble());
            }
        }
        for (int a = 0; a < count; a++) {
            for (int b = a + 1; b < count; b++) {
                for (int c = b + 1; c < count; c++) {
                    addIfFace(a, b, c);
                }
            }
        }
    }

    /** Three points are a face if all others are on one side of their plane. */
    private void addIfFace(int a, int b, int c) {
        int above = 0;
        int below = 0;
        for (int d = 0; d < points.length; d++) {
            if (d != a && d != b && d != c) {
                double side = side(points[a], points[b], points[c], points[d]);
                above += side > 0 ? 1 : 0;
                below += side < 0 ? 1 : 0;
            }
        }
        if (above == 0 || below == 0) {
            faces.add(above == 0 ? new int[] {a, b, c} : new int[] {a, c, b});
        }
    }

    /** Returns a positive number if (a, b, c) is counter-clockwise as seen from d. */
    private static double side(double[] a, double[] b, double[] c, double[] d) {
        double[] u = minus(b, a);
        double[] v = minus(c, a);
        double[] w = minus(d, a);
        return w[0] * (u[1] * v[2] - u[2] * v[1])
                + w[1] * (u[2] * v[0] - u[0] * v[2])
                + w[2] * (u[0] * v[1] - u[1] * v[0]);
    }

    private static double[] minus(double[] a, double[] b) {
        return new double[] {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    }

    /** Returns a mesh of the corners. Points inside the hull belong to no triangle. */
    Mesh mesh() {
        float[] vertices = new float[3 * points.length];
        for (int i = 0; i < vertices.length; i++) {
            vertices[i] = (float) points[i / 3][i % 3];
        }
        return new Mesh(vertices, faces.stream().flatMapToInt(Arrays::stream).toArray());
    }

    /**
     * Returns the integrals of 1, x, y, z, xx, yy, zz, yz, zx and xy over the solid, about a place.
     * Between two neighbouring heights of corners, the integral over a cut is a polynomial of the
     * height. Its degree is at most 4.
     */
    double[] integrals(double[] about) {
        double[] sums = new double[10];
        double[] heights = Arrays.stream(points).mapToDouble(point -> point[2]).sorted().toArray();
        for (int i = 1; i < heights.length; i++) {
            double half = 0.5 * (heights[i] - heights[i - 1]);
            for (int node = 0; node < NODES.length; node++) {
                double z = 0.5 * (heights[i] + heights[i - 1]) + half * NODES[node];
                addCut(sums, WEIGHTS[node] * half, z - about[2], cut(z, about));
            }
        }
        return sums;
    }

    private static void addCut(double[] sums, double weight, double z, List<double[]> polygon) {
        for (int i = 0; i < polygon.size(); i++) {
            double[] p = polygon.get(i);
            double[] q = polygon.get((i + 1) % polygon.size());
            // Green's theorem, edge by edge
            double turn = weight * (p[0] * q[1] - q[0] * p[1]);
            double area = turn / 2;
            double x = turn * (p[0] + q[0]) / 6;
            double y = turn * (p[1] + q[1]) / 6;
            double[] cut = {
                area,
                x,
                y,
                z * area,
                turn * (p[0] * p[0] + p[0] * q[0] + q[0] * q[0]) / 12,
                turn * (p[1] * p[1] + p[1] * q[1] + q[1] * q[1]) / 12,
                z * z * area,
                z * y,
                z * x,
                turn * (p[0] * q[1] + 2 * p[0] * p[1] + 2 * q[0] * q[1] + q[0] * p[1]) / 24
            };
            for (int k = 0; k < sums.length; k++) {
                sums[k] += cut[k];
            }
        }
    }

    /**
     * Returns the points at which edges pass through a height. They are the corners of a convex
     * polygon, in counter-clockwise order.
     */
    private List<double[]> cut(double z, double[] about) {
        List<double[]> corners = new ArrayList<>();
        for (int[] face : faces) {
            for (int i = 0; i < 3; i++) {
                double[] low = points[face[i]];
                double[] high = points[face[(i + 1) % 3]];
                if (low[2] < z && high[2] > z) { // each edge runs upward in one of its two faces
                    double share = (z - low[2]) / (high[2] - low[2]);
                    corners.add(
                            new double[] {
                                low[0] + share * (high[0] - low[0]) - about[0],
                                low[1] + share * (high[1] - low[1]) - about[1]
                            });
                }
            }
        }
        double x = corners.stream().mapToDouble(corner -> corner[0]).average().orElse(0);
        double y = corners.stream().mapToDouble(corner -> corner[1]).average().orElse(0);
        corners.sort(
                Comparator.comparingDouble(corner -> Math.atan2(corner[1] - y, corner[0] - x)));
        return corners;
    }
}
