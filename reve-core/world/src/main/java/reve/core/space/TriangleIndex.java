// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.lang.foreign.MemorySegment;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.stream.LongStream;

/** The triangles of a mesh, and a search for the first triangle on a ray. For one thread. */
public final class TriangleIndex {

    private final BoxIndex boxes = new BoxIndex();
    private final float[] corners;
    private final int[] triangles;
    private final double[] origin = new double[3];
    private final double[] direction = new double[3];
    private LocalRay ray = new LocalRay();
    private final BoxIndex.RayTest test = this::distance;

    /**
     * @param vertices (points x 3) coordinates in the axes of the item [m]
     * @param indices (triangles x 3) numbers of points
     */
    public TriangleIndex(FloatBuffer vertices, IntBuffer indices) {
        corners = new float[vertices.remaining()];
        vertices.duplicate().get(corners);
        triangles = new int[indices.remaining()];
        indices.duplicate().get(triangles);
        int count = triangles.length / 3;
        double[] low = new double[3 * count];
        double[] high = new double[3 * count];
        for (int i = 0; i < 3 * count; i++) {
            int axis = i % 3;
            int first = i - axis;
            float a = corners[3 * triangles[first] + axis];
            float b = corners[3 * triangles[first + 1] + axis];
            float c = corners[3 * triangles[first + 2] + axis];
            low[i] = Math.min(a, Math.min(b, c));
            high[i] = Math.max(a, Math.max(b, c));
        }
        boxes.build(
                MemorySegment.ofArray(LongStream.range(0, count).toArray()),
                MemorySegment.ofArray(low),
                MemorySegment.ofArray(high),
                count);
    }

    /**
     * Returns the distance along a ray to the first triangle, seen from either side [m]; infinite
     * if there is none up to a distance.
     *
     * @param ray in the axes of the item
     * @param effort limit on the search, see {@link BoxIndex#nearestOnRay}
     */
    public double distance(LocalRay ray, double most, Effort effort) {
        this.ray = ray;
        ray.copyTo(origin, direction);
        return boxes.nearestOnRay(origin, direction, most, test, effort);
    }

    private double distance(long triangle, double most) {
        int at = 3 * (int) triangle;
        return ray.toTriangle(
                corners, 3 * triangles[at], 3 * triangles[at + 1], 3 * triangles[at + 2]);
    }
}
