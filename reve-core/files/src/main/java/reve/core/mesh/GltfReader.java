// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import de.javagl.jgltf.impl.v2.GlTF;
import de.javagl.jgltf.impl.v2.MeshPrimitive;
import de.javagl.jgltf.impl.v2.Node;
import de.javagl.jgltf.model.GltfConstants;

import org.jspecify.annotations.Nullable;

import reve.core.world.Material;
import reve.core.world.Mesh;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Set;
import java.util.stream.IntStream;

/**
 * Reader of glTF 2.0 files. It returns one mesh with all triangles of the scene, transformed by
 * their nodes. It ignores cameras, lights, animations and morph targets. It refuses files that
 * require unsupported features which would change the triangles. The message names these features.
 */
final class GltfReader {

    private static final int MAX_DEPTH = 256;

    /**
     * Maximum number of primitives in all nodes of the scene. Lines and points count as primitives.
     */
    private static final int MAX_PIECES = 1 << 20;

    private final GlTF gltf;
    private final Sources sources;
    private final GltfAccessors accessors;
    private final GltfMaterials materials;
    private final MeshAssembler mesh;
    private final Set<Integer> placed = new HashSet<>();
    private int pieces;

    private GltfReader(GltfContainer file, Sources sources) {
        this.gltf = file.gltf();
        this.sources = sources;
        this.accessors = new GltfAccessors(file, sources);
        this.materials = new GltfMaterials(gltf, accessors, sources);
        this.mesh = new MeshAssembler(sources);
    }

    static Mesh read(byte[] bytes, Sources sources) throws AssetException {
        GltfContainer file = GltfContainer.read(bytes, sources);
        try {
            return new GltfReader(file, sources).read();
        } catch (RuntimeException broken) {
            // The library does not check whether values are missing or out of range. It then throws
            // unchecked exceptions, which are converted into a refusal of the file.
            throw sources.refuse("not glTF: " + Reason.of(broken, "it contradicts itself"));
        }
    }

    private Mesh read() throws AssetException {
        refuseExtensions();
        for (int root : roots()) {
            place(root, Placement.IDENTITY, 0);
        }
        return mesh.finish(true);
    }

    private void refuseExtensions() throws AssetException {
        List<String> required = orEmpty(gltf.getExtensionsRequired());
        if (required.isEmpty()) {
            return;
        }
        if (required.stream().anyMatch(Objects::isNull)) {
            throw sources.refuse("not glTF: extensionsRequired: found null, expected names");
        }
        boolean compressed =
                required.stream()
                        .anyMatch(name -> name.contains("draco") || name.contains("meshopt"));
        throw sources.refuse(
                "needs the glTF extension "
                        + required.getFirst()
                        + ", which is not supported; export it without"
                        + (compressed ? " compression" : ""));
    }

    /**
     * Returns the root nodes of the scene. Returns all nodes without a parent if the file has no
     * scene.
     */
    private List<Integer> roots() throws AssetException {
        List<Node> nodes = orEmpty(gltf.getNodes());
        if (!orEmpty(gltf.getScenes()).isEmpty()) {
            int scene = gltf.getScene() == null ? 0 : gltf.getScene();
            return orEmpty(element(gltf.getScenes(), scene, "scene").getNodes());
        }
        Set<Integer> children = new HashSet<>();
        for (int i = 0; i < nodes.size(); i++) {
            children.addAll(orEmpty(element(nodes, i, "node").getChildren()));
        }
        return IntStream.range(0, nodes.size())
                .boxed()
                .filter(node -> !children.contains(node))
                .toList();
    }

    private void place(@Nullable Integer number, Placement parent, int depth)
            throws AssetException {
        Node node = element(gltf.getNodes(), number, "node");
        if (!placed.add(number)) {
            throw sources.refuse("node " + number + " has two parents, or is its own ancestor");
        }
        if (depth > MAX_DEPTH) {
            throw sources.refuse("nodes are nested more than " + MAX_DEPTH + " deep");
        }
        if (node.getSkin() != null) {
            throw sources.refuse(
                    "node "
                            + number
                            + " has a skin, which is not supported; export "
                            + "the mesh as it stands, without its armature");
        }
        Placement placed = parent.times(placement(node));
        if (node.getMesh() != null) {
            List<MeshPrimitive> primitives =
                    orEmpty(element(gltf.getMeshes(), node.getMesh(), "mesh").getPrimitives());
            for (int i = 0; i < primitives.size(); i++) {
                add(element(primitives, i, "primitive"), placed);
            }
        }
        for (Integer child : orEmpty(node.getChildren())) {
            place(child, placed, depth + 1);
        }
    }

    private static Placement placement(Node node) {
        if (node.getMatrix() != null) {
            return Placement.of(node.getMatrix());
        }
        return Placement.of(
                node.getScale() == null ? node.defaultScale() : node.getScale(),
                node.getRotation() == null ? node.defaultRotation() : node.getRotation(),
                node.getTranslation() == null ? node.defaultTranslation() : node.getTranslation());
    }

    private void add(MeshPrimitive primitive, Placement placement) throws AssetException {
        if (++pieces > MAX_PIECES) {
            throw sources.refuse("nodes place more than " + MAX_PIECES + " primitives");
        }
        int mode = primitive.getMode() == null ? primitive.defaultMode() : primitive.getMode();
        if (mode < GltfConstants.GL_TRIANGLES) {
            return; // the reader ignores points and lines
        }
        Map<String, Integer> attributes =
                primitive.getAttributes() == null ? Map.of() : primitive.getAttributes();
        var positions = accessors.find(attributes.get("POSITION"), "position");
        var indices =
                primitive.getIndices() == null
                        ? null
                        : accessors.find(primitive.getIndices(), "index");
        int corners = indices == null ? positions.count() : indices.count();
        int triangles = mode == GltfConstants.GL_TRIANGLES ? corners / 3 : Math.max(0, corners - 2);
        mesh.reserve(positions.count(), triangles);
        Material material = materials.get(primitive.getMaterial());
        int first =
                addVertices(
                        attributes,
                        positions,
                        placement,
                        materials.coordinatesOf(primitive.getMaterial()));
        for (int i = 0; i < triangles; i++) {
            int[] at = corners(mode, i);
            if (placement.mirrors()) {
                at = new int[] {at[0], at[2], at[1]};
            }
            for (int corner = 0; corner < 3; corner++) {
                at[corner] =
                        first
                                + (indices == null
                                        ? at[corner]
                                        : indices.index(at[corner], positions.count()));
            }
            mesh.triangle(at[0], at[1], at[2], material);
        }
    }

    /**
     * Returns the positions of the three corners of a triangle in a triangle list, strip or fan.
     *
     * @param mode glTF code of a triangle list, strip or fan
     * @param i number of the triangle, from 0
     */
    private int[] corners(int mode, int i) throws AssetException {
        return switch (mode) {
            case GltfConstants.GL_TRIANGLES -> new int[] {3 * i, 3 * i + 1, 3 * i + 2};
            case GltfConstants.GL_TRIANGLE_STRIP -> new int[] {i, i + 1 + (i & 1), i + 2 - (i & 1)};
            case GltfConstants.GL_TRIANGLE_FAN -> new int[] {0, i + 1, i + 2};
            default -> throw sources.refuse("a primitive has mode " + mode + ", expected 0 to 6");
        };
    }

    private int addVertices(
            Map<String, Integer> attributes,
            GltfAccessors.Accessor positions,
            Placement placement,
            String coordinatesName)
            throws AssetException {
        positions.requireNumbers("POSITION", 3, 3, positions.count());
        var normals = attribute(attributes, "NORMAL", 3, 3, positions.count());
        var coordinates = attribute(attributes, coordinatesName, 2, 2, positions.count());
        var colours = attribute(attributes, "COLOR_0", 3, 4, positions.count());
        Placement turned = placement.forNormals();
        float side = placement.mirrors() ? -1 : 1;
        int first = -1;
        for (int i = 0; i < positions.count(); i++) {
            float x = positions.number(i, 0);
            float y = positions.number(i, 1);
            float z = positions.number(i, 2);
            int added =
                    mesh.vertex(
                            placement.point(0, x, y, z),
                            placement.point(1, x, y, z),
                            placement.point(2, x, y, z));
            first = i == 0 ? added : first;
            if (normals != null) {
                float nx = side * normals.number(i, 0);
                float ny = side * normals.number(i, 1);
                float nz = side * normals.number(i, 2);
                mesh.normal(
                        turned.point(0, nx, ny, nz),
                        turned.point(1, nx, ny, nz),
                        turned.point(2, nx, ny, nz));
            }
            if (coordinates != null) {
                mesh.coordinates(coordinates.number(i, 0), coordinates.number(i, 1));
            }
            if (colours != null) {
                mesh.colour(
                        GltfMaterials.toSrgb(
                                        colours.number(i, 0),
                                        colours.number(i, 1),
                                        colours.number(i, 2))
                                .rgba());
            }
        }
        return first;
    }

    private GltfAccessors.@Nullable Accessor attribute(
            Map<String, Integer> attributes, String name, int least, int most, int count)
            throws AssetException {
        if (attributes.get(name) == null) {
            return null;
        }
        var accessor = accessors.find(attributes.get(name), name);
        accessor.requireNumbers(name, least, most, count);
        return accessor;
    }

    private <T> T element(@Nullable List<T> list, @Nullable Integer number, String what)
            throws AssetException {
        return GltfContainer.element(list, number, what, sources);
    }

    private static <T> List<T> orEmpty(@Nullable List<T> list) {
        return list == null ? List.of() : new ArrayList<>(list);
    }
}
