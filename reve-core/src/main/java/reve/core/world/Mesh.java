package reve.core.world;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;

/** Triangles in metres around a body's origin, counter-clockwise seen from outside. */
public final class Mesh implements Shape {

    private final float[] vertices;
    private final int[] triangles;
    private final float[] low = {
        Float.POSITIVE_INFINITY, Float.POSITIVE_INFINITY, Float.POSITIVE_INFINITY
    };
    private final float[] high = {
        Float.NEGATIVE_INFINITY, Float.NEGATIVE_INFINITY, Float.NEGATIVE_INFINITY
    };

    /**
     * @param vertices (count x 3) coordinates [m]; copied
     * @param triangles (count x 3) indices of vertices; copied
     * @throws IllegalArgumentException if a number is missing, not finite or out of range
     */
    public Mesh(float[] vertices, int[] triangles) {
        this.vertices = vertices.clone();
        this.triangles = triangles.clone();
        requireTriples("coordinates", vertices.length);
        requireTriples("indices", triangles.length);
        for (int i = 0; i < vertices.length; i++) {
            float value = this.vertices[i];
            if (!Float.isFinite(value)) {
                throw new IllegalArgumentException("mesh vertex " + i / 3 + " has coordinate "
                        + value + ", expected a finite number");
            }
            low[i % 3] = Math.min(low[i % 3], value);
            high[i % 3] = Math.max(high[i % 3], value);
        }
        int vertexCount = vertices.length / 3;
        for (int i = 0; i < triangles.length; i++) {
            if (this.triangles[i] < 0 || this.triangles[i] >= vertexCount) {
                throw new IllegalArgumentException("mesh triangle " + i / 3 + " refers to vertex "
                        + this.triangles[i] + ", expected 0 to " + (vertexCount - 1));
            }
        }
    }

    /** (count x 3) coordinates [m], read only. */
    public FloatBuffer vertices() {
        return FloatBuffer.wrap(vertices).asReadOnlyBuffer();
    }

    /** (count x 3) indices of vertices, read only. */
    public IntBuffer triangles() {
        return IntBuffer.wrap(triangles).asReadOnlyBuffer();
    }

    /** Lowest coordinate along an own axis (0, 1, 2) [m]. */
    public double min(int axis) {
        return low[axis];
    }

    /** Highest coordinate along an own axis (0, 1, 2) [m]. */
    public double max(int axis) {
        return high[axis];
    }

    @Override
    public int code() {
        return MESH;
    }

    @Override
    public double size(int axis) {
        return (double) high[axis] - low[axis];
    }

    private static void requireTriples(String what, int count) {
        if (count == 0 || count % 3 != 0) {
            throw new IllegalArgumentException(
                    "mesh has " + count + " " + what + ", expected a multiple of 3, at least 3");
        }
    }
}
