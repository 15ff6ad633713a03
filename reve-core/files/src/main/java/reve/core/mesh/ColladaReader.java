// SPDX-License-Identifier: Apache-2.0
package reve.core.mesh;

import reve.core.world.Colour;
import reve.core.world.Material;
import reve.core.world.Mesh;

import java.util.Arrays;
import java.util.HashMap;
import java.util.Map;
import java.util.Optional;

/**
 * Reader of COLLADA files (versions 1.4 and 1.5). It returns one mesh in metres with all triangles
 * of the scene, transformed by their nodes. It ignores cameras, lights, animations and textures. It
 * refuses files with skins, and with other features that would change the triangles.
 */
final class ColladaReader {
    private static final int MAX_DEPTH = 64;

    /**
     * Maximum number of elements of all nodes and geometries in the scene. A node that occurs
     * several times counts as often.
     */
    private static final int MAX_PIECES = 1 << 20;

    private static final double MAX_UNIT = 1e6;

    private final Map<String, ColladaElement> byId = new HashMap<>();
    private final ColladaElement root;
    private final MeshAssembler mesh;
    private final Map<ColladaElement, Optional<Material>> materials = new HashMap<>();
    private final Map<ColladaElement, Map<String, Material>> bindings = new HashMap<>();
    private boolean hasMaterials;
    private int pieces;

    private ColladaReader(byte[] bytes, Sources sources) throws AssetException {
        this.root = ColladaElement.read(bytes, sources, byId);
        this.mesh = new MeshAssembler(sources);
    }

    /**
     * Reads a file.
     *
     * @param upright whether the mesh has +Y up, whatever the file's axis is; otherwise it keeps
     *     the axes of the file
     */
    static Mesh read(byte[] bytes, Sources sources, boolean upright) throws AssetException {
        return new ColladaReader(bytes, sources).read(upright);
    }

    private Mesh read(boolean upright) throws AssetException {
        if (!root.name().equals("COLLADA")) {
            throw root.refuse("expected <COLLADA>");
        }
        Placement placement = axes(upright).times(unit());
        Optional<ColladaElement> scene = root.path("scene", "instance_visual_scene");
        Optional<ColladaElement> library = root.child("library_visual_scenes");
        if (scene.isPresent()) {
            placeAll(target(scene.get(), "url"), placement, 0);
        } else if (library.isPresent()) {
            placeAll(
                    library.get()
                            .child("visual_scene")
                            .orElseThrow(() -> library.get().refuse("there is no scene in it")),
                    placement,
                    0);
        } else {
            for (ColladaElement geometries : root.all("library_geometries")) {
                for (ColladaElement geometry : geometries.all("geometry")) {
                    add(geometry, placement, Map.of());
                }
            }
        }
        return mesh.finish(hasMaterials);
    }

    private Placement unit() throws AssetException {
        Optional<ColladaElement> unit = root.path("asset", "unit");
        double metres = 1;
        if (unit.isPresent() && unit.get().find("meter").isPresent()) {
            String text = unit.get().find("meter").get();
            try {
                metres = Double.parseDouble(text);
            } catch (NumberFormatException none) {
                metres = Double.NaN;
            }
            if (!(metres > 0 && metres <= MAX_UNIT)) {
                throw unit.get()
                        .refuse(
                                "meter: found `"
                                        + text.substring(0, Math.min(text.length(), 64))
                                        + "`, expected a number of metres above 0 and at most 1e6");
            }
        }
        return new Placement(new double[] {metres, 0, 0, 0, 0, metres, 0, 0, 0, 0, metres, 0});
    }

    /** Returns the rotation from the axes of the file to axes with +Y up. */
    private Placement axes(boolean upright) throws AssetException {
        Optional<ColladaElement> axis = root.path("asset", "up_axis");
        String up = axis.map(ColladaElement::word).orElse("Y_UP");
        double[] rotation =
                switch (up) {
                    case "X_UP" -> new double[] {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};
                    case "Y_UP" -> new double[] {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
                    case "Z_UP" -> new double[] {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};
                    default ->
                            throw axis.orElseThrow()
                                    .refuse("found `" + up + "`, expected X_UP, Y_UP or Z_UP");
                };
        return upright ? new Placement(rotation) : Placement.IDENTITY;
    }

    /** Returns the element to which an attribute refers, as {@code #id}. */
    private ColladaElement target(ColladaElement from, String attribute) throws AssetException {
        String link = from.find(attribute).orElse("");
        ColladaElement found = link.startsWith("#") ? byId.get(link.substring(1)) : null;
        if (found == null) {
            throw from.refuse(
                    attribute
                            + ": found `"
                            + link.substring(0, Math.min(64, link.length()))
                            + "`, expected # and the id of an element of this file");
        }
        return found;
    }

    /** Adds the nodes and geometries in a scene or node. */
    private void placeAll(ColladaElement parent, Placement outer, int depth) throws AssetException {
        if (depth > MAX_DEPTH) {
            throw parent.refuse(
                    "the scene has more than " + MAX_DEPTH + " levels, or a node contains itself");
        }
        count(parent);
        Placement placement = outer;
        for (ColladaElement child : parent.children()) {
            switch (child.name()) {
                case "matrix", "translate", "rotate", "scale" ->
                        placement = placement.times(transformation(child));
                case "lookat", "skew" ->
                        throw child.refuse("this transformation is not supported; bake it");
                case "instance_controller" ->
                        throw child.refuse(
                                "a skin or morph is not supported; export the mesh as it stands,"
                                        + " without its armature");
                default -> {}
            }
        }
        for (ColladaElement child : parent.children()) {
            switch (child.name()) {
                case "node" -> placeAll(child, placement, depth + 1);
                case "instance_node" -> placeAll(target(child, "url"), placement, depth + 1);
                case "instance_geometry" ->
                        add(target(child, "url"), placement, materialsOf(child));
                default -> {}
            }
        }
    }

    /** Counts an element that is placed in the scene, and its children. */
    private void count(ColladaElement element) throws AssetException {
        pieces += 1 + element.children().size();
        if (pieces > MAX_PIECES) {
            throw element.refuse("the scene has more than " + MAX_PIECES + " elements");
        }
    }

    private static Placement transformation(ColladaElement element) throws AssetException {
        return switch (element.name()) {
            case "matrix" -> {
                double[] m = element.numbers(16);
                yield new Placement(Arrays.copyOf(m, 12));
            }
            case "translate" -> {
                double[] v = element.numbers(3);
                yield new Placement(new double[] {1, 0, 0, v[0], 0, 1, 0, v[1], 0, 0, 1, v[2]});
            }
            case "scale" -> {
                double[] v = element.numbers(3);
                yield new Placement(new double[] {v[0], 0, 0, 0, 0, v[1], 0, 0, 0, 0, v[2], 0});
            }
            default -> rotation(element);
        };
    }

    /** Returns the rotation by an angle [degrees] about an axis. */
    private static Placement rotation(ColladaElement element) throws AssetException {
        double[] v = element.numbers(4);
        double length = Math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        if (!(length > 0)) {
            if (v[3] == 0) {
                return Placement.IDENTITY;
            }
            throw element.refuse("the axis has no direction");
        }
        double half = Math.toRadians(v[3]) / 2;
        double sine = StrictMath.sin(half) / length;
        return Placement.of(
                new float[] {1, 1, 1},
                new float[] {
                    (float) (v[0] * sine),
                    (float) (v[1] * sine),
                    (float) (v[2] * sine),
                    (float) StrictMath.cos(half)
                },
                new float[3]);
    }

    // --- materials

    /** Returns the materials of a geometry by the symbols that its triangles name. */
    private Map<String, Material> materialsOf(ColladaElement instance) throws AssetException {
        Map<String, Material> known = bindings.get(instance);
        if (known != null) {
            return known;
        }
        Map<String, Material> bound = new HashMap<>();
        Optional<ColladaElement> technique = instance.path("bind_material", "technique_common");
        if (technique.isPresent()) {
            for (ColladaElement each : technique.get().all("instance_material")) {
                Optional<Material> material = material(target(each, "target"));
                if (material.isPresent() && each.find("symbol").isPresent()) {
                    bound.put(each.find("symbol").get(), material.get());
                }
            }
        }
        bindings.put(instance, bound);
        return bound;
    }

    /** Returns the material with the diffuse colour of an effect, if it has one. */
    private Optional<Material> material(ColladaElement material) throws AssetException {
        Optional<Material> known = materials.get(material);
        if (known == null) {
            Optional<ColladaElement> effect = material.child("instance_effect");
            known = effect.isEmpty() ? Optional.empty() : diffuse(target(effect.get(), "url"));
            materials.put(material, known);
        }
        return known;
    }

    private static Optional<Material> diffuse(ColladaElement effect) throws AssetException {
        Optional<ColladaElement> technique = effect.path("profile_COMMON", "technique");
        if (technique.isEmpty()) {
            return Optional.empty();
        }
        for (ColladaElement shading : technique.get().children()) {
            Optional<ColladaElement> colour = shading.path("diffuse", "color");
            if (colour.isPresent() && colour.get().count() >= 3) {
                int rgba = 0xff;
                for (int i = 0; i < 3; i++) {
                    float part = colour.get().number(i);
                    rgba |= Math.round(255 * Math.clamp(part, 0f, 1f)) << 24 - 8 * i;
                }
                Material usual = Material.DEFAULT;
                return Optional.of(
                        new Material(
                                Colour.parse("#%08x".formatted(rgba)),
                                usual.roughness(),
                                usual.metallic(),
                                Optional.empty()));
            }
        }
        return Optional.empty();
    }

    // --- geometries

    /** Adds the triangles of a geometry. */
    private void add(ColladaElement geometry, Placement placement, Map<String, Material> bound)
            throws AssetException {
        count(geometry);
        Optional<ColladaElement> found = geometry.child("mesh");
        if (found.isEmpty()) {
            throw geometry.refuse("found no <mesh>; export the geometry as triangles");
        }
        count(found.get());
        for (ColladaElement primitive : found.get().children()) {
            if (!ColladaPrimitive.NAMES.contains(primitive.name())) {
                continue;
            }
            count(primitive);
            Material material = bound.get(primitive.find("material").orElse(""));
            hasMaterials |= material != null;
            new ColladaPrimitive(
                            primitive,
                            this::target,
                            placement,
                            material == null ? Material.DEFAULT : material,
                            mesh)
                    .add();
        }
    }
}
