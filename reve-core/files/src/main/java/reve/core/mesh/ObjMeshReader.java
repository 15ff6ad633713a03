// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Material;
import reve.core.world.Mesh;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;

/**
 * Reader of Wavefront OBJ files. It returns one mesh in metres with all faces. Each face is split
 * into triangles that share its first corner. Groups are ignored. All lines are read before the
 * faces are built, because a face may refer to later lines.
 */
final class ObjMeshReader {

    private static final String[] NAMES = {"vertex", "vt", "vn"};
    private static final int MAX_MATERIALS = 65_536;
    private static final int NONE = -1;

    private final Sources sources;
    private final ObjLines lines;
    private final ObjMaterials materials;
    private final MeshAssembler mesh;

    /**
     * Three arrays: positions (count x 3), texture coordinates (count x 2) and normals (count x 3).
     */
    private final float[][] values = {new float[0], new float[0], new float[0]};

    private final int[] widths = {3, 2, 3};
    private final int[] counts = new int[3];

    /**
     * Indices of position, texture coordinates and normal of each corner (corners of all faces x
     * 3); -1 if a corner has none.
     */
    private int[] corners = new int[0];

    private int cornerCount;

    /**
     * Number of corners of each face, and index of its material in {@link #materialNames} (faces x
     * 2).
     */
    private int[] faces = new int[0];

    private int faceCount;
    private final Map<String, Integer> materialNumbers = new HashMap<>();
    private final List<String> materialNames = new ArrayList<>();

    private final CornerTable vertices = new CornerTable(1 << 11);

    private ObjMeshReader(byte[] bytes, Sources sources) {
        this.sources = sources;
        this.lines = new ObjLines(bytes, sources, "not OBJ");
        this.materials = new ObjMaterials(sources);
        this.mesh = new MeshAssembler(sources);
    }

    static Mesh read(byte[] bytes, Sources sources) throws AssetException {
        return new ObjMeshReader(bytes, sources).read();
    }

    private Mesh read() throws AssetException {
        readLines();
        mesh.reserve(0, 0);
        int corner = 0;
        for (int face = 0; face < faceCount; face++) {
            int number = faces[2 * face + 1];
            add(
                    corner,
                    faces[2 * face],
                    number == NONE ? Material.DEFAULT : materials.get(materialNames.get(number)));
            corner += faces[2 * face];
        }
        return mesh.finish(!materials.isEmpty());
    }

    private void readLines() throws AssetException {
        int material = NONE;
        while (lines.next()) {
            if (lines.is("v")) {
                take(0, "v");
            } else if (lines.is("vt")) {
                take(1, "vt");
            } else if (lines.is("vn")) {
                take(2, "vn");
            } else if (lines.is("f")) {
                takeFace(material);
            } else if (lines.is("usemtl")) {
                material = materialNumber(lines.rest());
            } else if (lines.is("mtllib")) {
                materials.readLibrary(lines.rest());
            }
            lines.skipLine();
        }
    }

    /**
     * Reads one line of numbers into a list of {@link #values}. The second texture coordinate is
     * optional.
     */
    private void take(int list, String keyword) throws AssetException {
        int width = widths[list];
        int at = width * counts[list];
        requireRoom(counts[list] + 1);
        if (at + width > values[list].length) {
            values[list] = Arrays.copyOf(values[list], grown(at, width));
        }
        for (int i = 0; i < width; i++) {
            values[list][at + i] =
                    list == 1 && i == 1 ? lines.word() ? lines.number() : 0 : lines.number(keyword);
        }
        counts[list]++;
    }

    private void takeFace(int material) throws AssetException {
        int before = cornerCount;
        int[] corner = new int[3];
        while (lines.word()) {
            lines.corner(counts, corner);
            requireRoom((cornerCount + 1) / 3);
            if (3 * cornerCount + 3 > corners.length) {
                corners = Arrays.copyOf(corners, grown(3 * cornerCount, 3));
            }
            System.arraycopy(corner, 0, corners, 3 * cornerCount++, 3);
        }
        if (cornerCount - before < 3) {
            cornerCount =
                    before; // a face of one or two corners is a point or a line and is ignored
            return;
        }
        if (2 * faceCount + 2 > faces.length) {
            faces = Arrays.copyOf(faces, grown(2 * faceCount, 2));
        }
        faces[2 * faceCount] = cornerCount - before;
        faces[2 * faceCount++ + 1] = material;
    }

    private int materialNumber(String name) throws AssetException {
        Integer number = materialNumbers.get(name);
        if (number == null) {
            number = materialNames.size();
            if (number >= MAX_MATERIALS) {
                throw sources.refuse("more than " + MAX_MATERIALS + " materials");
            }
            materialNumbers.put(name, number);
            materialNames.add(name);
        }
        return number;
    }

    private void requireRoom(int count) throws AssetException {
        if (count > Mesh.MAX_COUNT) {
            throw sources.refuse(
                    "more than "
                            + Mesh.MAX_COUNT
                            + " vertices or triangles; simplify "
                            + "the mesh");
        }
    }

    private static int grown(int length, int width) {
        return Math.max(1024 * width, length + length / 2 / width * width);
    }

    private void add(int firstCorner, int count, Material material) throws AssetException {
        mesh.reserve(0, count - 2L);
        int first = vertex(firstCorner);
        int previous = vertex(firstCorner + 1);
        for (int corner = firstCorner + 2; corner < firstCorner + count; corner++) {
            int next = vertex(corner);
            mesh.triangle(first, previous, next, material);
            previous = next;
        }
    }

    /**
     * Returns the number of the vertex for a corner. Adds a vertex if no earlier corner has the
     * same three indices.
     */
    private int vertex(int corner) throws AssetException {
        int at = 3 * corner;
        int known = vertices.find(corners, at);
        if (known >= 0) {
            return known;
        }
        mesh.reserve(1, 0);
        int position = place(at, 0);
        int added =
                mesh.vertex(values[0][position], values[0][position + 1], values[0][position + 2]);
        if (corners[at + 1] >= 0) {
            int coordinates = place(at, 1);
            mesh.coordinates(values[1][coordinates], 1 - values[1][coordinates + 1]);
        }
        if (corners[at + 2] >= 0) {
            int normal = place(at, 2);
            mesh.normal(values[2][normal], values[2][normal + 1], values[2][normal + 2]);
        }
        vertices.add(corners, at, added);
        return added;
    }

    /**
     * Returns the index in {@link #values} at which the position, texture coordinates or normal of
     * a corner begin.
     */
    private int place(int at, int list) throws AssetException {
        int index = corners[at + list];
        if (index >= counts[list]) {
            throw sources.refuse(
                    "a face refers to "
                            + NAMES[list]
                            + " "
                            + (index + 1L)
                            + ", there are "
                            + counts[list]);
        }
        return widths[list] * index;
    }
}
