// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Colour;
import reve.core.world.Material;
import reve.core.world.Mesh;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/**
 * Builder of one mesh from pieces. A piece without an attribute, such as normals, gets default
 * values if another piece has this attribute.
 */
final class MeshAssembler {

    private final Sources sources;
    private float[] positions = new float[0];
    private float[] normals = new float[0];
    private float[] coordinates = new float[0];
    private int[] colours = new int[0];
    private int[] triangles = new int[0];
    private int vertexCount;
    private int indexCount;
    private boolean hasNormals;
    private boolean hasCoordinates;
    private boolean hasColours;
    private final List<Mesh.Part> parts = new ArrayList<>();

    MeshAssembler(Sources sources) {
        this.sources = sources;
    }

    /**
     * Allocates space for more vertices and triangles. Throws an exception if the mesh would have
     * too many of them.
     */
    void reserve(long vertices, long newTriangles) throws AssetException {
        requireRoom("vertices", vertexCount + vertices);
        requireRoom("triangles", indexCount / 3 + newTriangles);
        sources.budget().takeVertices(sources.path(), vertices);
        sources.budget().takeTriangles(sources.path(), newTriangles);
        int wanted = vertexCount + (int) vertices;
        if (wanted > colours.length) {
            int count = grown(colours.length, wanted);
            positions = Arrays.copyOf(positions, 3 * count);
            normals = Arrays.copyOf(normals, 3 * count);
            coordinates = Arrays.copyOf(coordinates, 2 * count);
            colours = Arrays.copyOf(colours, count);
        }
        int indices = indexCount + 3 * (int) newTriangles;
        if (indices > triangles.length) {
            triangles = Arrays.copyOf(triangles, 3 * grown(triangles.length / 3, indices / 3));
        }
    }

    private void requireRoom(String what, long count) throws AssetException {
        if (count > Mesh.MAX_COUNT) {
            throw sources.refuse(
                    "more than " + Mesh.MAX_COUNT + " " + what + "; simplify the mesh");
        }
    }

    private static int grown(int now, int wanted) {
        return Math.min(Math.max(wanted, 2 * now), Mesh.MAX_COUNT);
    }

    /**
     * Adds a vertex, which is white by default, and returns its number. The caller must first call
     * {@link #reserve}.
     */
    int vertex(float x, float y, float z) {
        int at = 3 * vertexCount;
        positions[at] = x;
        positions[at + 1] = y;
        positions[at + 2] = z;
        colours[vertexCount] = Colour.WHITE.rgba();
        return vertexCount++;
    }

    /** Sets the normal of the last vertex. */
    void normal(float x, float y, float z) {
        int at = 3 * vertexCount - 3;
        normals[at] = x;
        normals[at + 1] = y;
        normals[at + 2] = z;
        hasNormals = true;
    }

    /** Sets the texture coordinates of the last vertex. */
    void coordinates(float u, float v) {
        coordinates[2 * vertexCount - 2] = u;
        coordinates[2 * vertexCount - 1] = v;
        hasCoordinates = true;
    }

    /** Sets the colour of the last vertex. */
    void colour(int rgba) {
        colours[vertexCount - 1] = rgba;
        hasColours = true;
    }

    /**
     * Adds a triangle with a material. The caller must first call {@link #reserve}. Successive
     * triangles with equal materials form one part.
     */
    void triangle(int a, int b, int c, Material material) {
        int first = indexCount / 3;
        triangles[indexCount++] = a;
        triangles[indexCount++] = b;
        triangles[indexCount++] = c;
        Mesh.Part last = parts.isEmpty() ? null : parts.getLast();
        if (last != null && last.material().equals(material)) {
            parts.set(
                    parts.size() - 1,
                    new Mesh.Part(last.firstTriangle(), last.triangleCount() + 1, material));
        } else {
            parts.add(new Mesh.Part(first, 1, material));
        }
    }

    /**
     * Returns the complete mesh.
     *
     * @param ownMaterials whether the mesh keeps the materials of its triangles
     */
    Mesh finish(boolean ownMaterials) throws AssetException {
        if (indexCount == 0) {
            throw sources.refuse("there are no triangles in it");
        }
        Mesh.Builder mesh =
                Mesh.builder(
                                Arrays.copyOf(positions, 3 * vertexCount),
                                Arrays.copyOf(triangles, indexCount))
                        .file(sources.path());
        if (hasNormals) {
            mesh.normals(Arrays.copyOf(normals, 3 * vertexCount));
        }
        if (hasCoordinates) {
            mesh.textureCoordinates(Arrays.copyOf(coordinates, 2 * vertexCount));
        }
        if (hasColours) {
            mesh.colours(Arrays.copyOf(colours, vertexCount));
        }
        if (ownMaterials) {
            parts.forEach(part -> mesh.part(part.triangleCount(), part.material()));
        }
        try {
            return mesh.build();
        } catch (IllegalArgumentException unfit) {
            throw sources.refuse(unfit.getMessage());
        }
    }
}
