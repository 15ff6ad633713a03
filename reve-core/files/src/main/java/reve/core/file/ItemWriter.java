// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.Action;
import reve.core.world.Colour;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemClass;
import reve.core.world.ItemDefinition;
import reve.core.world.Level;
import reve.core.world.Likeness;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Parameter;
import reve.core.world.PropertyDescriptor;
import reve.core.world.Relief;
import reve.core.world.ScalarType;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.Texture;
import reve.core.world.Voice;
import reve.core.world.WorldPrototype;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;
import java.util.function.BiConsumer;

/**
 * Writer of items as text in the form of a world file. The same item always gives the same text.
 * {@link WorldFile#parseItem} reads this text back to the bit. Default values are omitted, for
 * example properties that are 0. Immutable. For any thread.
 */
public final class ItemWriter {
    /** Name of the item in the text of data that have no item name, such as a {@link Likeness}. */
    private static final String ANYBODY = "item";

    private final WorldPrototype prototype;

    /** Whether numbers are written with full precision even if columns of the world round them. */
    private final boolean isExact;

    /** Receives the expressions of actions that are written, with the parameters of the action. */
    private final BiConsumer<List<Parameter>, String> expressions;

    /**
     * @param prototype prototype of the world that contains the items
     */
    public ItemWriter(WorldPrototype prototype) {
        this(prototype, false, (_, _) -> {});
    }

    /**
     * @param expressions receives the expressions of actions that are written, with the parameters
     *     of the action; called on the thread that writes
     */
    ItemWriter(WorldPrototype prototype, BiConsumer<List<Parameter>, String> expressions) {
        this(prototype, false, expressions);
    }

    private ItemWriter(
            WorldPrototype prototype,
            boolean isExact,
            BiConsumer<List<Parameter>, String> expressions) {
        this.prototype = prototype;
        this.isExact = isExact;
        this.expressions = expressions;
    }

    /**
     * Writes an item with its four aspects.
     *
     * @throws IllegalArgumentException naming the item if a world file cannot express a part of it:
     *     an action of a program, or a mesh or texture without a file
     */
    public String write(ItemDefinition item) {
        return YamlWriter.write(tree(item));
    }

    /**
     * Writes the data that similar items share, as an item with the name `item`.
     *
     * @throws IllegalArgumentException like {@link #write(ItemDefinition)}
     */
    public String write(Likeness item) {
        Map<String, Object> tree = named(ANYBODY, item.kind());
        Map<String, Object> physical = shape(ANYBODY, item.shape());
        item.material()
                .ifPresent(material -> physical.put("material", material(ANYBODY, material)));
        putLook(physical, item.look());
        putIfAny(tree, "physical", physical);
        putIfAny(tree, "access", actions(ANYBODY, item.actions()));
        putCapabilities(tree, item.capabilities());
        putIfAny(tree, "sensors", sensors(item.sensors()));
        item.voice().ifPresent(voice -> tree.put("voice", voice(voice)));
        putIfAny(tree, LevelReader.LEVELS, levels(item.levels()));
        return YamlWriter.write(tree);
    }

    Map<String, Object> tree(ItemDefinition item) {
        Map<String, Object> tree = named(item.name(), item.kind());
        putAspects(tree, item);
        return tree;
    }

    /**
     * Returns the tree of an item without name and kind. This is the form of the key {@code
     * agents.body}.
     */
    Map<String, Object> template(ItemDefinition item) {
        Map<String, Object> tree = new LinkedHashMap<>();
        putAspects(tree, item);
        return tree;
    }

    private static Map<String, Object> named(String name, String kind) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put("name", name);
        if (!kind.equals(WorldPrototype.BODY)) {
            tree.put("kind", kind);
        }
        return tree;
    }

    private void putAspects(Map<String, Object> tree, ItemDefinition item) {
        item.parent().ifPresent(parent -> tree.put("parent", parent));
        putIfAny(tree, "physical", physical(item));
        putIfAny(tree, "semantic", symbols(item.symbols()));
        putIfAny(tree, "access", actions(item.name(), item.actions()));
        putCapabilities(tree, item.capabilities());
        putIfAny(tree, "physics", physics(item));
        putIfAny(tree, "sensors", sensors(item.sensors()));
        item.voice().ifPresent(voice -> tree.put("voice", voice(voice)));
        putIfAny(tree, LevelReader.LEVELS, levels(item.levels()));
    }

    /**
     * Returns the tree of the levels of an item. Their numbers have full precision, so that the
     * parts of a level have the same bits before and after the item is stored.
     */
    private Map<String, Object> levels(List<Level> levels) {
        var exact = new ItemWriter(prototype, true, expressions);
        Map<String, Object> all = new LinkedHashMap<>();
        for (Level level : levels) {
            Map<String, Object> tree = new LinkedHashMap<>();
            if (level.isGroup()) {
                Map<String, Object> parts = new LinkedHashMap<>();
                level.items().forEach(part -> parts.put(part.name(), exact.part(part)));
                tree.put(GroupReader.PARTS, parts);
            } else {
                tree.putAll(exact.template(level.items().getFirst()));
            }
            level.when().ifPresent(when -> tree.put(LevelReader.WHEN, when.text()));
            all.put(level.name(), tree);
        }
        return all;
    }

    private Map<String, Object> part(ItemDefinition item) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (!item.kind().equals(WorldPrototype.BODY)) {
            tree.put("kind", item.kind());
        }
        putAspects(tree, item);
        return tree;
    }

    /** Returns the tree of a voice. Omits default values. */
    private static Map<String, Object> voice(Voice voice) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (Double.isFinite(voice.range())) {
            tree.put("range", YamlWriter.Numeral.of(voice.range()));
        }
        if (Double.isFinite(voice.fading())) {
            tree.put("fading", YamlWriter.Numeral.of(voice.fading()));
        }
        return tree;
    }

    private static Map<String, Object> sensors(List<Sensor> sensors) {
        Map<String, Object> all = new LinkedHashMap<>();
        sensors.forEach(sensor -> all.put(sensor.name(), sensor(sensor)));
        return all;
    }

    /** Returns the tree of a sensor. Omits default values. */
    private static Map<String, Object> sensor(Sensor sensor) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (sensor.hearing()) {
            tree.put("hearing", true);
        }
        if (sensor.touch()) {
            tree.put("touch", true);
        }
        if (sensor.range() != (sensor.touch() ? Sensor.TOUCH_RANGE : Double.POSITIVE_INFINITY)) {
            tree.put("range", YamlWriter.Numeral.of(sensor.range()));
        }
        if (sensor.fieldOfView() != Sensor.ALL_ROUND) {
            tree.put("fieldOfView", YamlWriter.Numeral.of(sensor.fieldOfView()));
        }
        if (sensor.lineOfSight()) {
            tree.put("lineOfSight", true);
        }
        sensor.camera().ifPresent(camera -> tree.put("camera", camera(camera)));
        sensor.instrument().ifPresent(instrument -> InstrumentWriter.write(instrument, tree));
        if (sensor.every() != 1) {
            tree.put("every", YamlWriter.Numeral.of(sensor.every()));
        }
        sensor.symbols().ifPresent(names -> tree.put("symbols", List.copyOf(names)));
        if (sensor.sensesItems() && sensor.aspects().size() < Sensor.Aspect.values().length) {
            tree.put(
                    "aspects",
                    sensor.aspects().stream()
                            .sorted()
                            .map(aspect -> aspect.name().toLowerCase(Locale.ROOT))
                            .toList());
        }
        return tree;
    }

    private static Map<String, Object> camera(Sensor.Camera camera) {
        Map<String, Object> tree = new LinkedHashMap<>();
        tree.put(
                "size",
                List.of(
                        YamlWriter.Numeral.of(camera.width()),
                        YamlWriter.Numeral.of(camera.height())));
        tree.put(
                "layers",
                camera.layers().stream()
                        .sorted()
                        .map(layer -> layer.name().toLowerCase(Locale.ROOT))
                        .toList());
        return tree;
    }

    private static void putIfAny(Map<String, Object> tree, String key, Map<String, Object> aspect) {
        if (!aspect.isEmpty()) {
            tree.put(key, aspect);
        }
    }

    private static void putCapabilities(Map<String, Object> tree, List<String> capabilities) {
        if (!capabilities.isEmpty()) {
            tree.put("capabilities", capabilities);
        }
    }

    private Map<String, Object> physical(ItemDefinition item) {
        Map<String, Object> aspect = shape(item.name(), item.shape());
        item.material()
                .ifPresent(material -> aspect.put("material", material(item.name(), material)));
        if (!item.colour().equals(Colour.defaultOf(item.shape(), item.material()))) {
            aspect.put("colour", hex(item.colour()));
        }
        putLook(aspect, item.look());
        // A pose relative to a parent is written with full precision, because it is not stored in a
        // column. Columns round their values to the real type of the world.
        ScalarType real =
                isExact || item.parent().isPresent() ? ScalarType.F64 : prototype.realType();
        if (!isZero(item.location())) {
            aspect.put("location", numbers(real, item.location()));
        }
        double[] turn = item.orientation();
        if (!isZero(turn[0], turn[1], turn[2]) || turn[3] != 1) {
            aspect.put("orientation", numbers(real, turn));
        }
        return aspect;
    }

    private static void putLook(Map<String, Object> physical, ConnectionLook look) {
        look.colour().ifPresent(colour -> physical.put("colour", hex(colour)));
        if (look.width() != 0) {
            physical.put(ConnectionLook.WIDTH, YamlWriter.Numeral.of(look.width()));
        }
    }

    private static String hex(Colour colour) {
        String text = colour.toString();
        return text.endsWith("ff") ? text.substring(0, 7) : text;
    }

    private static Map<String, Object> shape(String item, Shape shape) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (shape) {
            case Shape.None none -> {}
            case Shape.Sphere sphere -> {
                tree.put("shape", "sphere");
                tree.put("radius", YamlWriter.Numeral.of(sphere.radius()));
            }
            case Shape.Box box -> {
                tree.put("shape", "box");
                tree.put("size", numbers(ScalarType.F64, box.x(), box.y(), box.z()));
            }
            case Shape.Plane plane -> {
                tree.put("shape", "plane");
                tree.put("size", numbers(ScalarType.F64, plane.x(), plane.z()));
            }
            case Shape.Capsule capsule -> {
                tree.put("shape", "capsule");
                tree.put("radius", YamlWriter.Numeral.of(capsule.radius()));
                tree.put("height", YamlWriter.Numeral.of(capsule.height()));
            }
            case Shape.Cylinder cylinder -> {
                tree.put("shape", "cylinder");
                tree.put("radius", YamlWriter.Numeral.of(cylinder.radius()));
                tree.put("height", YamlWriter.Numeral.of(cylinder.height()));
            }
            case Shape.Ellipsoid round -> {
                tree.put("shape", "ellipsoid");
                tree.put("size", numbers(ScalarType.F64, round.x(), round.y(), round.z()));
            }
            case Mesh mesh when mesh.relief().isPresent() && mesh.file().isPresent() ->
                    putTerrain(tree, mesh);
            case Mesh mesh -> {
                tree.put("shape", "mesh");
                if (mesh.file().isPresent()) {
                    tree.put("file", mesh.file().get());
                } else if (mesh.normals().isPresent()
                        || mesh.textureCoordinates().isPresent()
                        || mesh.colours().isPresent()
                        || !mesh.parts().isEmpty()) {
                    throw new IllegalArgumentException(
                            "item "
                                    + item
                                    + " has a mesh of more than triangles that is in no file");
                } else {
                    tree.put("vertices", vertices(mesh.vertices()));
                    tree.put("triangles", triangles(mesh.triangles()));
                }
            }
        }
        return tree;
    }

    private static void putTerrain(Map<String, Object> tree, Mesh mesh) {
        Relief relief = mesh.relief().orElseThrow();
        tree.put("shape", "terrain");
        tree.put("size", numbers(ScalarType.F64, relief.x(), relief.z()));
        tree.put("file", mesh.file().orElseThrow());
        relief.range()
                .ifPresent(
                        range ->
                                tree.put(
                                        "heightRange",
                                        numbers(ScalarType.F64, range.least(), range.greatest())));
    }

    private static Map<String, Object> material(String item, Material material) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (material.texture().isPresent() && material.texture().get().file().isEmpty()) {
            throw new IllegalArgumentException(
                    "item " + item + " has a texture that is in no file of its own");
        }
        if (!material.colour().equals(Colour.WHITE)) {
            tree.put("colour", hex(material.colour()));
        }
        tree.put("roughness", YamlWriter.Numeral.of(material.roughness()));
        tree.put("metallic", YamlWriter.Numeral.of(material.metallic()));
        material.texture().flatMap(Texture::file).ifPresent(file -> tree.put("texture", file));
        return tree;
    }

    private static List<Object> vertices(FloatBuffer coordinates) {
        List<Object> points = new ArrayList<>();
        while (coordinates.hasRemaining()) {
            points.add(
                    numbers(
                            ScalarType.F32,
                            coordinates.get(),
                            coordinates.get(),
                            coordinates.get()));
        }
        return points;
    }

    private static List<Object> triangles(IntBuffer indices) {
        List<Object> corners = new ArrayList<>();
        while (indices.hasRemaining()) {
            corners.add(numbers(ScalarType.I32, indices.get(), indices.get(), indices.get()));
        }
        return corners;
    }

    static Map<String, Object> symbols(Map<String, Object> symbols) {
        Map<String, Object> aspect = new TreeMap<>();
        symbols.forEach((name, value) -> aspect.put(name, symbol(value)));
        return aspect;
    }

    /**
     * Converts the value of a symbol (text, boolean, number, or a list of these) for {@link
     * YamlWriter}.
     */
    static Object symbol(Object value) {
        return switch (value) {
            case List<?> list -> list.stream().map(ItemWriter::symbol).toList();
            case Double number -> YamlWriter.Numeral.of(number);
            default -> value;
        };
    }

    private Map<String, Object> actions(String item, List<Action> actions) {
        Map<String, Object> aspect = new LinkedHashMap<>();
        for (Action action : actions) {
            try {
                aspect.put(action.name(), new ActionWriter(this::tree, expressions).tree(action));
            } catch (IllegalArgumentException refused) {
                throw new IllegalArgumentException("item " + item + ": " + refused.getMessage());
            }
        }
        return aspect;
    }

    /**
     * Returns the physics properties that are not 0, in the order of the prototype. Returns the
     * first property of the kind if all properties are 0, so that the item keeps a physics aspect.
     */
    private Map<String, Object> physics(ItemDefinition item) {
        Map<String, Object> aspect = new LinkedHashMap<>();
        List<PropertyDescriptor> properties =
                prototype.properties().stream()
                        .filter(property -> property.kind().equals(item.kind()))
                        .toList();
        for (PropertyDescriptor property : properties) {
            List<String> targets = item.references().getOrDefault(property.name(), List.of());
            if (!targets.isEmpty()) {
                aspect.put(property.name(), targets.size() == 1 ? targets.getFirst() : targets);
            }
            item.physics(property.name())
                    .filter(values -> !isZero(values))
                    .ifPresent(
                            values ->
                                    aspect.put(
                                            property.name(),
                                            quantity(
                                                    isExact ? ScalarType.F64 : property.type(),
                                                    values)));
        }
        if (item.hasPhysics()) {
            putZeros(aspect, item, properties);
        }
        if (aspect.isEmpty() && item.hasPhysics()) {
            PropertyDescriptor first = properties.getFirst();
            aspect.put(first.name(), quantity(first.type(), new double[first.components()]));
        }
        return aspect;
    }

    /**
     * Explicitly writes the properties that are 0 and for which the item's class has another
     * initial value.
     */
    private void putZeros(
            Map<String, Object> aspect, ItemDefinition item, List<PropertyDescriptor> properties) {
        if (!(item.symbols().get("class") instanceof String itemClass)) {
            return;
        }
        Set<String> initial = prototype.classes().properties(itemClass).keySet();
        for (PropertyDescriptor property : properties) {
            boolean isMass =
                    property.name().equals(WorldPrototype.MASS)
                            && initial.contains(ItemClass.DENSITY);
            if (isMass || initial.contains(property.name())) {
                aspect.putIfAbsent(
                        property.name(),
                        quantity(property.type(), new double[property.components()]));
            }
        }
    }

    /** Returns whether all values are +0, the initial value of columns. */
    static boolean isZero(double... values) {
        for (double value : values) {
            if (Double.doubleToRawLongBits(value) != 0) {
                return false;
            }
        }
        return true;
    }

    static Object quantity(ScalarType type, double... values) {
        return values.length == 1 ? numeral(type, values[0]) : numbers(type, values);
    }

    private static List<Object> numbers(ScalarType type, double... values) {
        List<Object> numerals = new ArrayList<>(values.length);
        for (double value : values) {
            numerals.add(numeral(type, value));
        }
        return numerals;
    }

    private static YamlWriter.Numeral numeral(ScalarType type, double value) {
        return type == ScalarType.F32
                ? YamlWriter.Numeral.of((float) value)
                : YamlWriter.Numeral.of(value);
    }
}
