// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import org.jspecify.annotations.Nullable;

import reve.core.world.Material;

import java.util.List;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;

/**
 * A set of triangles or polygons of a COLLADA geometry. Polygons are split into triangles that
 * share the first corner. For one thread.
 */
final class ColladaPrimitive {
    /** Names of the elements that this class reads. The others are lines. */
    static final Set<String> NAMES =
            Set.of("triangles", "polylist", "polygons", "tristrips", "trifans");

    private static final int POSITION = 0;
    private static final int COORDINATES = 1;
    private static final int NORMAL = 2;
    private static final int MAX_STRIDE = 64;

    /** Maximum number of inputs of a primitive or of its vertices. */
    private static final int MAX_INPUTS = 64;

    /** Resolves the reference that an attribute of an element contains. */
    interface Links {
        ColladaElement target(ColladaElement from, String attribute) throws AssetException;
    }

    /**
     * A list of vectors.
     *
     * @param array the element with the numbers
     * @param offset index of the first number of the first vector
     * @param stride distance of two vectors
     * @param count number of vectors
     */
    private record Source(ColladaElement array, int offset, int stride, int count) {
        float number(int vector, int component) {
            return array.number(offset + stride * vector + component);
        }
    }

    private final ColladaElement element;
    private final Links links;
    private final Placement placement;
    private final Placement forNormals;
    private final boolean mirrored;

    /** Sign of the normals, which {@link #forNormals} inverts in a mirrored geometry. */
    private final float side;

    private final Material material;
    private final MeshAssembler mesh;

    /** Position, texture coordinates and normal; null if the primitive has none. */
    private final @Nullable Source[] sources = new Source[3];

    /** Place of the index into each source among the indices of a corner. */
    private final int[] offsets = new int[3];

    private int stride = 1;

    ColladaPrimitive(
            ColladaElement element,
            Links links,
            Placement placement,
            Material material,
            MeshAssembler mesh) {
        this.element = element;
        this.links = links;
        this.placement = placement;
        this.forNormals = placement.forNormals();
        this.mirrored = placement.mirrors();
        this.side = mirrored ? -1 : 1;
        this.material = material;
        this.mesh = mesh;
    }

    /** Adds all triangles to the mesh. */
    void add() throws AssetException {
        readInputs();
        List<ColladaElement> lists = element.all("p");
        if (element.name().equals("polygons") && element.child("ph").isPresent()) {
            throw element.refuse("polygons with holes are not supported; export triangles");
        }
        if (element.name().equals("polylist") && lists.size() > 1) {
            throw lists.get(1).refuse("found a second <p> in a <polylist>, expected one");
        }
        for (ColladaElement list : lists) {
            if (list.count() % stride != 0) {
                throw list.refuse(
                        "found " + list.count() + " numbers, expected a multiple of " + stride);
            }
            var corners = new Corners(list);
            switch (element.name()) {
                case "triangles" -> addTriangles(corners);
                case "polylist" -> addPolygons(corners);
                case "tristrips" -> addStrip(corners);
                default -> addFan(corners, 0, corners.count());
            }
        }
    }

    /** Returns the inputs of an element. */
    private static List<ColladaElement> inputs(ColladaElement of) throws AssetException {
        List<ColladaElement> inputs = of.all("input");
        if (inputs.size() > MAX_INPUTS) {
            throw of.refuse("found " + inputs.size() + " inputs, expected at most " + MAX_INPUTS);
        }
        return inputs;
    }

    private void readInputs() throws AssetException {
        for (ColladaElement input : inputs(element)) {
            int offset = input.whole("offset", 0);
            if (offset >= MAX_STRIDE) {
                throw input.refuse("the offset is " + offset + ", expected less than 64");
            }
            stride = Math.max(stride, offset + 1);
            switch (input.find("semantic").orElse("")) {
                case "VERTEX" -> {
                    for (ColladaElement part : inputs(links.target(input, "source"))) {
                        take(part, offset);
                    }
                }
                default -> take(input, offset);
            }
        }
        if (sources[POSITION] == null) {
            throw element.refuse("found no positions, expected an input VERTEX");
        }
    }

    /**
     * Takes an input with a known meaning. Of several inputs with one meaning, the first counts.
     */
    private void take(ColladaElement input, int offset) throws AssetException {
        int kind =
                switch (input.find("semantic").orElse("")) {
                    case "POSITION" -> POSITION;
                    case "TEXCOORD" -> COORDINATES;
                    case "NORMAL" -> NORMAL;
                    default -> -1;
                };
        if (kind >= 0 && sources[kind] == null) {
            sources[kind] = source(links.target(input, "source"), kind == COORDINATES ? 2 : 3);
            offsets[kind] = offset;
        }
    }

    private Source source(ColladaElement source, int components) throws AssetException {
        Optional<ColladaElement> accessor = source.path("technique_common", "accessor");
        if (accessor.isEmpty()) {
            throw source.refuse("found no <accessor> of <technique_common>");
        }
        ColladaElement array = links.target(accessor.get(), "source");
        int step = accessor.get().whole("stride", 1);
        int offset = accessor.get().whole("offset", 0);
        int count = accessor.get().whole("count", 0);
        long needed = count == 0 ? 0 : offset + (count - 1L) * step + components;
        if (step < components || needed > array.count()) {
            throw accessor.get()
                    .refuse(
                            count
                                    + " vectors with a stride of "
                                    + step
                                    + " from number "
                                    + offset
                                    + " do not fit "
                                    + array.count()
                                    + " numbers and "
                                    + components
                                    + " components");
        }
        return new Source(array, offset, step, count);
    }

    private void addTriangles(Corners corners) throws AssetException {
        if (corners.count() % 3 != 0) {
            throw element.refuse("found " + corners.count() + " corners, expected a multiple of 3");
        }
        for (int corner = 0; corner < corners.count(); corner += 3) {
            addFan(corners, corner, 3);
        }
    }

    private void addPolygons(Corners corners) throws AssetException {
        Optional<ColladaElement> counts = element.child("vcount");
        int next = 0;
        for (int i = 0; counts.isPresent() && i < counts.get().count(); i++) {
            int count = counts.get().index(i);
            if (count > corners.count() - next) {
                break;
            }
            if (count < 3) {
                mesh.reserve(0, 1); // also counts as a triangle, because reading it takes time
            }
            addFan(corners, next, count);
            next += count;
        }
        if (next != corners.count()) {
            throw element.refuse(
                    "the numbers of <vcount> have another sum than the "
                            + corners.count()
                            + " corners of <p>");
        }
    }

    private void addFan(Corners corners, int first, int count) throws AssetException {
        for (int i = 2; i < count; i++) {
            triangle(corners, first, first + i - 1, first + i);
        }
    }

    private void addStrip(Corners corners) throws AssetException {
        for (int i = 2; i < corners.count(); i++) {
            boolean odd = i % 2 == 1;
            triangle(corners, odd ? i - 1 : i - 2, odd ? i - 2 : i - 1, i);
        }
    }

    private void triangle(Corners corners, int a, int b, int c) throws AssetException {
        mesh.reserve(0, 1);
        int first = corners.vertex(a);
        int second = corners.vertex(mirrored ? c : b);
        int third = corners.vertex(mirrored ? b : c);
        mesh.triangle(first, second, third, material);
    }

    /** The corners of one list. Corners with the same indices share a vertex. */
    private final class Corners {
        private final ColladaElement list;
        private final CornerTable table;
        private final int[] key = new int[3];

        Corners(ColladaElement list) {
            this.list = list;
            this.table = new CornerTable(count(list) / 4);
        }

        private int count(ColladaElement numbers) {
            return numbers.count() / stride;
        }

        int count() {
            return count(list);
        }

        int vertex(int corner) throws AssetException {
            for (int kind = 0; kind < 3; kind++) {
                Source source = sources[kind];
                key[kind] = source == null ? -1 : list.index(stride * corner + offsets[kind]);
                if (source != null && key[kind] >= source.count) {
                    throw list.refuse(
                            "found the index "
                                    + key[kind]
                                    + ", expected less than "
                                    + source.count);
                }
            }
            int known = table.find(key, 0);
            if (known >= 0) {
                return known;
            }
            mesh.reserve(1, 0);
            int added = addVertex();
            table.add(key, 0, added);
            return added;
        }

        private int addVertex() {
            Source at = Objects.requireNonNull(sources[POSITION]);
            float x = at.number(key[POSITION], 0);
            float y = at.number(key[POSITION], 1);
            float z = at.number(key[POSITION], 2);
            int added =
                    mesh.vertex(
                            placement.point(0, x, y, z),
                            placement.point(1, x, y, z),
                            placement.point(2, x, y, z));
            Source coordinates = sources[COORDINATES];
            if (coordinates != null) {
                mesh.coordinates(
                        coordinates.number(key[COORDINATES], 0),
                        1 - coordinates.number(key[COORDINATES], 1));
            }
            Source normals = sources[NORMAL];
            if (normals != null) {
                float nx = side * normals.number(key[NORMAL], 0);
                float ny = side * normals.number(key[NORMAL], 1);
                float nz = side * normals.number(key[NORMAL], 2);
                mesh.normal(
                        forNormals.point(0, nx, ny, nz),
                        forNormals.point(1, nx, ny, nz),
                        forNormals.point(2, nx, ny, nz));
            }
            return added;
        }
    }
}
