// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import reve.core.hull.ConvexHull;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Optional;

/**
 * Triangles in metres around a body's origin, counter-clockwise as seen from outside. Immutable.
 * Items with equal shapes share one mesh.
 */
public final class Mesh implements Shape {

    /** Maximum number of vertices, and of triangles, of one mesh. */
    public static final int MAX_COUNT = 1 << 20;

    private final float[] vertices;
    private final int[] triangles;
    private final float @Nullable [] normals;
    private final float @Nullable [] textureCoordinates;
    private final int @Nullable [] colours;
    private final List<Part> parts;
    private final Optional<String> file;
    private final Optional<Relief> relief;
    private final float[] low = filled(Float.POSITIVE_INFINITY);
    private final float[] high = filled(Float.NEGATIVE_INFINITY);

    /** Convex hull of the vertices; null until it is first needed. */
    private volatile @Nullable Optional<ConvexHull> hull;

    /**
     * A range of successive triangles with one material.
     *
     * @param firstTriangle index of the first triangle
     * @param triangleCount number of triangles, at least 1
     */
    public record Part(int firstTriangle, int triangleCount, Material material) {}

    /**
     * Creates a mesh of flat triangles that have the item's material.
     *
     * @param vertices (count x 3) coordinates [m]; copied
     * @param triangles (count x 3) indices of vertices; copied
     * @throws IllegalArgumentException if a number is missing, not finite or out of range
     */
    public Mesh(float[] vertices, int[] triangles) {
        this(new Builder(vertices, triangles));
    }

    private Mesh(Builder builder) {
        vertices = builder.vertices.clone();
        triangles = builder.triangles.clone();
        requireTriples("coordinates", vertices.length);
        requireTriples("indices", triangles.length);
        for (int i = 0; i < vertices.length; i++) {
            requireFinite("vertex " + i / 3 + " has coordinate", vertices[i]);
            low[i % 3] = Math.min(low[i % 3], vertices[i]);
            high[i % 3] = Math.max(high[i % 3], vertices[i]);
        }
        int count = vertices.length / 3;
        for (int i = 0; i < triangles.length; i++) {
            if (triangles[i] < 0 || triangles[i] >= count) {
                throw new IllegalArgumentException(
                        "mesh triangle "
                                + i / 3
                                + " refers to vertex "
                                + triangles[i]
                                + ", expected 0 to "
                                + (count - 1));
            }
        }
        normals = perVertex("normals", builder.normals, 3 * count);
        textureCoordinates =
                perVertex("texture coordinates", builder.textureCoordinates, 2 * count);
        colours = builder.colours == null ? null : builder.colours.clone();
        if (colours != null && colours.length != count) {
            throw new IllegalArgumentException(
                    "mesh has "
                            + colours.length
                            + " colours, expected one for each of "
                            + count
                            + " vertices");
        }
        parts = List.copyOf(builder.parts);
        requireParts(parts, triangles.length / 3);
        file = builder.file;
        relief = builder.relief;
    }

    /**
     * Begins a mesh with further attributes. The arrays have the form of {@link #Mesh(float[],
     * int[])}.
     */
    public static Builder builder(float[] vertices, int[] triangles) {
        return new Builder(vertices, triangles);
    }

    /** Returns (count x 3) coordinates [m], read only. */
    public FloatBuffer vertices() {
        return FloatBuffer.wrap(vertices).asReadOnlyBuffer();
    }

    /** Returns (count x 3) indices of vertices, read only. */
    public IntBuffer triangles() {
        return IntBuffer.wrap(triangles).asReadOnlyBuffer();
    }

    /**
     * Returns (count x 3) normals of the vertices, read only. A triangle whose corners have the
     * normal 0 0 0 is drawn flat. All triangles are drawn flat if the mesh has no normals.
     */
    public Optional<FloatBuffer> normals() {
        return readOnly(normals);
    }

    /**
     * Returns (count x 2) texture coordinates of the vertices. The upper left corner of the image
     * has the coordinates 0 0, and the lower right corner has 1 1.
     */
    public Optional<FloatBuffer> textureCoordinates() {
        return readOnly(textureCoordinates);
    }

    /**
     * Returns (count) colours of the vertices as {@link Colour#rgba()}, which multiply the
     * material's colour.
     */
    public Optional<IntBuffer> colours() {
        return Optional.ofNullable(colours).map(all -> IntBuffer.wrap(all).asReadOnlyBuffer());
    }

    /**
     * Returns the ranges of triangles by material, in order and without gaps. All triangles have
     * the item's material if the list is empty.
     */
    public List<Part> parts() {
        return parts;
    }

    /**
     * Returns the path of the mesh's file, relative to the world's folder; empty if it has none.
     */
    public Optional<String> file() {
        return file;
    }

    /** Returns the measures of the terrain, if the mesh is one. */
    public Optional<Relief> relief() {
        return relief;
    }

    /** Returns the smallest coordinate along an axis of the shape (0, 1, 2) [m]. */
    public double min(int axis) {
        return low[axis];
    }

    /** Returns the largest coordinate along an axis of the shape (0, 1, 2) [m]. */
    public double max(int axis) {
        return high[axis];
    }

    /**
     * Returns the convex hull of the vertices, which is computed once. Returns empty if {@link
     * ConvexHull#of} refuses the vertices.
     */
    public Optional<ConvexHull> hull() {
        Optional<ConvexHull> known = hull;
        if (known == null) {
            try {
                known = Optional.of(requireHull());
            } catch (IllegalArgumentException degenerate) {
                known = Optional.empty();
            }
            hull = known;
        }
        return known;
    }

    /**
     * Returns the convex hull of the vertices.
     *
     * @throws IllegalArgumentException naming the reason why {@link ConvexHull#of} refuses the
     *     vertices
     */
    public ConvexHull requireHull() {
        double[] points = new double[vertices.length];
        for (int i = 0; i < points.length; i++) {
            points[i] = vertices[i];
        }
        return ConvexHull.of(points);
    }

    @Override
    public int code() {
        return MESH;
    }

    @Override
    public double size(int axis) {
        return (double) high[axis] - low[axis];
    }

    private static float[] filled(float value) {
        float[] three = new float[3];
        Arrays.fill(three, value);
        return three;
    }

    private static void requireTriples(String what, int count) {
        if (count == 0 || count % 3 != 0 || count / 3 > MAX_COUNT) {
            throw new IllegalArgumentException(
                    "mesh has "
                            + count
                            + " "
                            + what
                            + ", expected a multiple of 3, from 3 to "
                            + 3 * MAX_COUNT);
        }
    }

    private static void requireFinite(String what, float value) {
        if (!Float.isFinite(value)) {
            throw new IllegalArgumentException(
                    "mesh " + what + " " + value + ", expected a finite number");
        }
    }

    private static float @Nullable [] perVertex(
            String what, float @Nullable [] values, int expected) {
        if (values == null) {
            return null;
        }
        if (values.length != expected) {
            throw new IllegalArgumentException(
                    "mesh has "
                            + values.length
                            + " numbers for "
                            + what
                            + ", expected "
                            + expected);
        }
        for (float value : values) {
            requireFinite("has among its " + what, value);
        }
        return values.clone();
    }

    private static void requireParts(List<Part> parts, int triangleCount) {
        int next = 0;
        for (Part part : parts) {
            if (part.firstTriangle != next
                    || part.triangleCount < 1
                    || part.triangleCount > triangleCount - next) {
                throw new IllegalArgumentException(
                        "mesh part from triangle "
                                + part.firstTriangle
                                + " with "
                                + part.triangleCount
                                + " triangles, expected one from "
                                + next
                                + " within "
                                + triangleCount);
            }
            next += part.triangleCount;
        }
        if (!parts.isEmpty() && next != triangleCount) {
            throw new IllegalArgumentException(
                    "mesh parts end at triangle " + next + " of " + triangleCount);
        }
    }

    private static Optional<FloatBuffer> readOnly(float @Nullable [] values) {
        return Optional.ofNullable(values).map(all -> FloatBuffer.wrap(all).asReadOnlyBuffer());
    }

    /**
     * Builder of further attributes of a mesh. The method {@link #build} checks and copies them.
     */
    public static final class Builder {
        private final float[] vertices;
        private final int[] triangles;
        private float @Nullable [] normals;
        private float @Nullable [] textureCoordinates;
        private int @Nullable [] colours;
        private final List<Part> parts = new ArrayList<>();
        private Optional<String> file = Optional.empty();
        private Optional<Relief> relief = Optional.empty();

        private Builder(float[] vertices, int[] triangles) {
            this.vertices = vertices;
            this.triangles = triangles;
        }

        /** Sets the normals, see {@link Mesh#normals}. */
        public Builder normals(float[] values) {
            normals = values;
            return this;
        }

        /** Sets the texture coordinates, see {@link Mesh#textureCoordinates}. */
        public Builder textureCoordinates(float[] values) {
            textureCoordinates = values;
            return this;
        }

        /** Sets the colours, see {@link Mesh#colours}. */
        public Builder colours(int[] rgba) {
            colours = rgba;
            return this;
        }

        /** Assigns a material to the next {@code triangleCount} triangles. */
        public Builder part(int triangleCount, Material material) {
            int first =
                    parts.isEmpty()
                            ? 0
                            : parts.getLast().firstTriangle + parts.getLast().triangleCount;
            parts.add(new Part(first, triangleCount, material));
            return this;
        }

        /** Sets the file, see {@link Mesh#file}. */
        public Builder file(String relativePath) {
            file = Optional.of(relativePath);
            return this;
        }

        /** Sets the measures of a terrain, see {@link Mesh#relief}. */
        public Builder relief(Relief measures) {
            relief = Optional.of(measures);
            return this;
        }

        /**
         * Returns the mesh.
         *
         * @throws IllegalArgumentException if a number is missing, not finite or out of range
         */
        public Mesh build() {
            return new Mesh(this);
        }
    }
}
