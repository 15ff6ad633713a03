// SPDX-License-Identifier: Apache-2.0
package reve.core.hull;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/** Merger of the triangles of a hull. Triangles that lie in one plane become one face. */
final class Merging {
    /** Cosine of the largest angle between a triangle and the face to which it is added. */
    private static final double PARALLEL = 0.99;

    private final double[] points;
    private final List<int[]> triangles;
    private final double flat;
    private final double[][] normals;

    /** The triangle at each directed edge. The key of an edge is {@link #edge}. */
    private final Map<Long, Integer> byEdge = new HashMap<>();

    /** The face of each triangle; -1 if it has none yet. */
    private final int[] faceOf;

    /**
     * @param flat maximum distance of a face's corners from the plane of the face [m]
     */
    Merging(double[] points, List<int[]> triangles, double flat) {
        this.points = points;
        this.triangles = triangles;
        this.flat = flat;
        normals = new double[triangles.size()][];
        faceOf = new int[triangles.size()];
        Arrays.fill(faceOf, -1);
        for (int i = 0; i < triangles.size(); i++) {
            int[] corners = triangles.get(i);
            normals[i] = ConvexHull.normalOf(points, corners);
            for (int k = 0; k < 3; k++) {
                byEdge.put(edge(corners[k], corners[(k + 1) % 3]), i);
            }
        }
    }

    ConvexHull hull(double extent) {
        List<int[]> faces = new ArrayList<>();
        List<Integer> bySize = new ArrayList<>();
        for (int i = 0; i < triangles.size(); i++) {
            bySize.add(i);
        }
        bySize.sort(Comparator.comparingDouble(triangle -> -area(triangles.get(triangle))));
        for (int triangle : bySize) {
            if (faceOf[triangle] < 0) {
                List<Integer> region = region(triangle, faces.size());
                Optional<int[]> outline = outline(region, faces.size());
                if (outline.isEmpty()) {
                    region.forEach(member -> faceOf[member] = -1);
                    faceOf[triangle] = faces.size();
                }
                faces.add(outline.orElse(triangles.get(triangle)));
            }
        }
        return numbered(faces, extent);
    }

    private static long edge(int from, int to) {
        return (long) from << 32 | to;
    }

    private double area(int[] corners) {
        double[] sum = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            int u = (axis + 1) % 3;
            int v = (axis + 2) % 3;
            sum[axis] =
                    along(corners, 1, u) * along(corners, 2, v)
                            - along(corners, 1, v) * along(corners, 2, u);
        }
        return sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
    }

    private double along(int[] corners, int corner, int axis) {
        return points[3 * corners[corner] + axis] - points[3 * corners[0] + axis];
    }

    /**
     * Returns the connected triangles that lie in the plane of one triangle. Records {@code face}
     * as their face.
     */
    private List<Integer> region(int triangle, int face) {
        List<Integer> region = new ArrayList<>(List.of(triangle));
        faceOf[triangle] = face;
        for (int i = 0; i < region.size(); i++) {
            int[] corners = triangles.get(region.get(i));
            for (int k = 0; k < 3; k++) {
                int beside = byEdge.get(edge(corners[(k + 1) % 3], corners[k]));
                if (faceOf[beside] < 0 && isInPlane(beside, triangle)) {
                    faceOf[beside] = face;
                    region.add(beside);
                }
            }
        }
        return region;
    }

    private boolean isInPlane(int triangle, int base) {
        double[] normal = normals[base];
        double[] other = normals[triangle];
        double cosine = normal[0] * other[0] + normal[1] * other[1] + normal[2] * other[2];
        boolean sliver = other[0] == 0 && other[1] == 0 && other[2] == 0;
        if (!sliver && cosine < PARALLEL) {
            return false;
        }
        int origin = triangles.get(base)[0];
        for (int corner : triangles.get(triangle)) {
            double height = 0;
            for (int axis = 0; axis < 3; axis++) {
                height += normal[axis] * (points[3 * corner + axis] - points[3 * origin + axis]);
            }
            if (Math.abs(height) > flat) {
                return false;
            }
        }
        return true;
    }

    /** Returns the corners around a region in order; empty if the region has no single outline. */
    private Optional<int[]> outline(List<Integer> region, int face) {
        Map<Integer, Integer> next = new HashMap<>();
        int first = -1;
        int edges = 0;
        for (int triangle : region) {
            int[] corners = triangles.get(triangle);
            for (int k = 0; k < 3; k++) {
                int from = corners[k];
                int to = corners[(k + 1) % 3];
                if (faceOf[byEdge.get(edge(to, from))] != face) {
                    next.put(from, to);
                    edges++;
                    first = first < 0 ? from : first;
                }
            }
        }
        if (next.size() != edges || edges < 3) {
            return Optional.empty();
        }
        int[] outline = new int[edges];
        int corner = first;
        for (int i = 0; i < edges; i++) {
            outline[i] = corner;
            corner = next.get(corner);
            if (corner == first && i + 1 < edges) {
                return Optional.empty();
            }
        }
        return Optional.of(outline);
    }

    /**
     * Returns the hull with only those corners at which three or more faces meet, in the order of
     * the points. The other points lie on an edge or in a face.
     */
    private ConvexHull numbered(List<int[]> faces, double extent) {
        Map<Integer, Integer> uses = new HashMap<>();
        for (int[] face : faces) {
            for (int corner : face) {
                uses.merge(corner, 1, Integer::sum);
            }
        }
        int[] kept =
                uses.keySet().stream()
                        .filter(corner -> uses.get(corner) > 2)
                        .mapToInt(Integer::intValue)
                        .sorted()
                        .toArray();
        double[] corners = new double[3 * kept.length];
        for (int i = 0; i < kept.length; i++) {
            System.arraycopy(points, 3 * kept[i], corners, 3 * i, 3);
        }
        int[][] all =
                faces.stream()
                        .map(
                                face ->
                                        Arrays.stream(face)
                                                .map(corner -> Arrays.binarySearch(kept, corner))
                                                .filter(corner -> corner >= 0)
                                                .toArray())
                        .filter(face -> face.length > 2)
                        .toArray(int[][]::new);
        return ConvexHull.of(corners, all, extent);
    }
}
