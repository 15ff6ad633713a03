// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.AssetException;
import reve.core.mesh.Assets;
import reve.core.text.Rounded;
import reve.core.unit.Unit;
import reve.core.world.Colour;
import reve.core.world.ConnectionLook;
import reve.core.world.ItemDefinition;
import reve.core.world.Material;
import reve.core.world.Mesh;
import reve.core.world.Relief;
import reve.core.world.ScalarType;
import reve.core.world.Shape;
import reve.core.world.Texture;
import reve.core.world.WorldPrototype;

import java.util.LinkedHashSet;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BiFunction;

/** Reader of physical aspects: shape, material, colour, location and orientation. */
final class PhysicalReader {
    private static final Unit METRE = Unit.parse("m");

    /** Least whole number that is unlikely for an angle in radians. */
    private static final double LEAST_WHOLE = 2;

    private static final Map<String, Set<String>> KEYS_BY_SHAPE =
            Map.of(
                    "sphere",
                    Set.of("radius"),
                    "box",
                    Set.of("size"),
                    "plane",
                    Set.of("size"),
                    "capsule",
                    new LinkedHashSet<>(List.of("radius", "height")),
                    "cylinder",
                    new LinkedHashSet<>(List.of("radius", "height")),
                    "ellipsoid",
                    Set.of("size"),
                    "terrain",
                    new LinkedHashSet<>(List.of("size", "heights")),
                    "mesh",
                    new LinkedHashSet<>(List.of("vertices", "triangles")));

    /** Keys that a file replaces. */
    private static final Set<String> OF_MESHES = Set.of("heights", "vertices", "triangles");

    /** Shapes that a file may contain. */
    private static final Set<String> MESHES = Set.of("mesh", "terrain");

    /** The keys that describe a shape. */
    static final List<String> SHAPE_KEYS =
            List.of(
                    "shape",
                    "radius",
                    "height",
                    "size",
                    "heights",
                    "vertices",
                    "triangles",
                    "file",
                    "heightRange");

    /** The keys of springs. Surfaces have only the first one. */
    static final Set<String> CONNECTION_KEYS = Set.of("colour", ConnectionLook.WIDTH);

    private final WorldPrototype prototype;
    private final PhysicsReader physics;
    private final Assets assets;
    private final BiFunction<Node, String, String> pathOf;
    private final Problems problems;
    private final Quantities quantities;

    /**
     * @param pathOf returns the path of a file that a value names, relative to the folder of the
     *     assets
     */
    PhysicalReader(
            WorldPrototype prototype,
            PhysicsReader physics,
            Assets assets,
            BiFunction<Node, String, String> pathOf,
            Problems problems) {
        this.prototype = prototype;
        this.physics = physics;
        this.assets = assets;
        this.pathOf = pathOf;
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    void read(Node aspect, ItemDefinition.Builder item) {
        aspect.children().forEach(value -> readPlaceOrColour(value, item));
        aspect.get(ConnectionLook.WIDTH)
                .ifPresent(width -> problems.addAtKey(width, noWidth(WorldPrototype.BODY)));
        aspect.get("orientation").flatMap(node -> node.get("angle")).ifPresent(this::doubtAngle);
        shape(aspect, item);
        aspect.get("material").filter(Node::isMapping).ifPresent(node -> material(node, item));
    }

    /** Reads the appearance of a spring or a surface. */
    void readLook(Node aspect, String kind, ItemDefinition.Builder item) {
        for (Node value : aspect.children()) {
            switch (value.key()) {
                case "colour" ->
                        value.text()
                                .ifPresent(
                                        text ->
                                                attempt(
                                                        value,
                                                        () -> setColour(item, Colour.parse(text))));
                case ConnectionLook.WIDTH -> readWidth(value, kind, item);
                default ->
                        problems.addAtKey(
                                value,
                                "`"
                                        + value.key()
                                        + "` does not go with kind "
                                        + kind
                                        + "; in `physical`, a spring has only `colour` and `width`,"
                                        + " and a surface only `colour`");
            }
        }
    }

    private static void setColour(ItemDefinition.Builder item, Colour colour) {
        item.look(item.look().with(colour));
    }

    private void readWidth(Node value, String kind, ItemDefinition.Builder item) {
        if (!kind.equals(WorldPrototype.SPRING)) {
            problems.addAtKey(value, noWidth(kind));
            return;
        }
        quantities
                .number(value, METRE)
                .filter(metres -> physics.isWorkable(value, metres))
                .ifPresent(metres -> attempt(value, () -> item.look(item.look().with(metres))));
    }

    private static String noWidth(String kind) {
        return "only items of kind spring have a `width`, this is a " + kind;
    }

    /** Reads a value if its key is location, orientation or colour. Ignores other keys. */
    void readPlaceOrColour(Node value, ItemDefinition.Builder item) {
        switch (value.key()) {
            case "colour" ->
                    value.text().ifPresent(colour -> attempt(value, () -> item.colour(colour)));
            case "location" ->
                    quantities
                            .numbers(value, 3, METRE)
                            .filter(at -> physics.fits(value, prototype.realType(), at))
                            .ifPresent(at -> item.at(at[0], at[1], at[2]));
            case "orientation" -> orientation(value, item);
            default -> {}
        }
    }

    private void orientation(Node node, ItemDefinition.Builder item) {
        Optional<double[]> quaternion =
                node.isMapping() ? aroundAxis(node) : quantities.numbers(node, 4, Unit.ONE);
        quaternion.ifPresent(q -> attempt(node, () -> item.orientation(q[0], q[1], q[2], q[3])));
    }

    /**
     * Warns of an angle without a unit that exceeds a full turn, or is a whole number from 2 on.
     * Such a number is in radians, but its author probably meant degrees.
     */
    private void doubtAngle(Node node) {
        node.number()
                .filter(
                        radians ->
                                Math.abs(radians) > 2 * Math.PI
                                        || Math.abs(radians) >= LEAST_WHOLE
                                                && radians == Math.rint(radians))
                .ifPresent(
                        radians ->
                                problems.warn(
                                        node,
                                        String.format(
                                                Locale.ROOT,
                                                "angle: %s rad are %.1f turns, because a number"
                                                        + " without a unit is in radians; write"
                                                        + " `%s deg` if you mean degrees%s",
                                                Rounded.of(radians),
                                                Math.abs(radians) / (2 * Math.PI),
                                                Rounded.of(radians),
                                                Math.abs(radians) > 2 * Math.PI
                                                        ? ""
                                                        : ", or `"
                                                                + Rounded.of(radians)
                                                                + " rad`")));
    }

    private Optional<double[]> aroundAxis(Node node) {
        Optional<double[]> axis =
                node.get("axis").flatMap(value -> quantities.numbers(value, 3, Unit.ONE));
        Optional<Double> angle =
                node.get("angle").flatMap(value -> quantities.number(value, Unit.ONE));
        if (axis.isEmpty() || angle.isEmpty()) {
            return Optional.empty();
        }
        double[] a = axis.get();
        double length = Math.hypot(Math.hypot(a[0], a[1]), a[2]);
        if (length == 0 || !Double.isFinite(length)) {
            problems.add(
                    node.get("axis").orElseThrow(),
                    "axis: has no direction, expected one such as 0 1 0");
            return Optional.empty();
        }
        double sine = StrictMath.sin(angle.get() / 2);
        return Optional.of(
                new double[] {
                    a[0] / length * sine,
                    a[1] / length * sine,
                    a[2] / length * sine,
                    StrictMath.cos(angle.get() / 2)
                });
    }

    private void shape(Node aspect, ItemDefinition.Builder item) {
        Optional<Node> node = aspect.get("shape");
        String name = node.flatMap(Node::text).orElse("");
        Set<String> wanted = keys(name, aspect);
        if (node.isPresent() && wanted.isEmpty()) {
            return; // the shape is unknown, which the schema check has reported
        }
        boolean complete = true;
        for (String key : SHAPE_KEYS.subList(1, SHAPE_KEYS.size())) {
            Optional<Node> value = aspect.get(key);
            if (value.isPresent() && !wanted.contains(key)) {
                problems.addAtKey(
                        value.get(),
                        name.isEmpty()
                                ? "`" + key + "` without a `shape`"
                                : "`"
                                        + key
                                        + "` does not go with shape "
                                        + name
                                        + ", which takes `"
                                        + String.join("` and `", wanted)
                                        + "`");
            } else if (value.isEmpty() && wanted.contains(key)) {
                complete = false;
                if (problems.isMisspelt(aspect)) {
                    continue;
                }
                problems.add(
                        node.orElseThrow(),
                        "shape "
                                + name
                                + " needs `"
                                + key
                                + "`"
                                + (key.equals("heightRange") ? " for an image" : "")
                                + (OF_MESHES.contains(key) ? " (or a `file`)" : ""));
            }
        }
        if (complete && node.isPresent() && !problems.isMisspelt(aspect)) {
            Node size =
                    wanted.stream()
                            .map(aspect::get)
                            .flatMap(Optional::stream)
                            .findFirst()
                            .orElse(node.get());
            attempt(size, () -> form(name, aspect).ifPresent(item::shape));
        }
    }

    /** Returns whether a physical aspect has a shape with all of its keys. */
    static boolean hasWholeShape(Node physical) {
        Set<String> keys = keys(physical.get("shape").flatMap(Node::text).orElse(""), physical);
        return !keys.isEmpty() && keys.stream().allMatch(key -> physical.get(key).isPresent());
    }

    /** Returns the keys of a shape. Those of meshes and terrains depend on the file. */
    private static Set<String> keys(String shape, Node aspect) {
        Optional<String> file = aspect.get("file").map(node -> node.text().orElse(""));
        if (file.isEmpty() || !MESHES.contains(shape)) {
            return KEYS_BY_SHAPE.getOrDefault(shape, Set.of());
        }
        if (shape.equals("mesh")) {
            return Set.of("file");
        }
        return new LinkedHashSet<>(
                Assets.isImageOfHeights(file.get())
                        ? List.of("size", "file", "heightRange")
                        : List.of("size", "file"));
    }

    private Optional<Shape> form(String name, Node aspect) {
        return switch (name) {
            case "sphere" -> lengths(aspect, "radius", 1).map(radius -> Shape.sphere(radius[0]));
            case "box" ->
                    lengths(aspect, "size", 3).map(size -> Shape.box(size[0], size[1], size[2]));
            case "plane" -> lengths(aspect, "size", 2).map(size -> Shape.plane(size[0], size[1]));
            case "capsule" -> round(aspect, Shape::capsule);
            case "cylinder" -> round(aspect, Shape::cylinder);
            case "ellipsoid" ->
                    lengths(aspect, "size", 3)
                            .map(size -> Shape.ellipsoid(size[0], size[1], size[2]));
            case "terrain" ->
                    aspect.get("file").isPresent()
                            ? relief(aspect, aspect.get("file").get())
                            : terrain(aspect);
            default ->
                    aspect.get("file").isPresent()
                            ? file(aspect.get("file").get())
                            : mesh(
                                    aspect.get("vertices").orElseThrow(),
                                    aspect.get("triangles").orElseThrow());
        };
    }

    private interface Round {
        Shape of(double radius, double height);
    }

    private Optional<Shape> round(Node aspect, Round shape) {
        Optional<double[]> radius = lengths(aspect, "radius", 1);
        Optional<double[]> height = lengths(aspect, "height", 1);
        return radius.isEmpty() || height.isEmpty()
                ? Optional.empty()
                : Optional.of(shape.of(radius.get()[0], height.get()[0]));
    }

    /**
     * Returns the mesh of a height field. It contains two triangles for each four neighbouring
     * heights.
     */
    private Optional<Shape> terrain(Node aspect) {
        Optional<double[]> size = lengths(aspect, "size", 2);
        Node heights = aspect.get("heights").orElseThrow();
        List<Node> rows = List.copyOf(heights.children());
        int columns = rows.isEmpty() ? 0 : rows.getFirst().children().size();
        if (!heights.isList() || rows.size() < 2 || columns < 2) {
            problems.add(
                    heights,
                    "heights: expected at least two lists of at least two heights, one list for"
                            + " each row from -z to +z");
            return Optional.empty();
        }
        if ((long) rows.size() * columns > Mesh.MAX_COUNT / 2) {
            problems.add(
                    heights,
                    "heights: found "
                            + rows.size()
                            + " x "
                            + columns
                            + " numbers, expected at most "
                            + Mesh.MAX_COUNT / 2
                            + " in total");
            return Optional.empty();
        }
        float[] vertices = new float[3 * rows.size() * columns];
        int next = 0;
        for (int j = 0; j < rows.size(); j++) {
            Node row = rows.get(j);
            Optional<double[]> numbers =
                    quantities
                            .numbers(row, columns, METRE)
                            .filter(metres -> physics.fits(row, ScalarType.F32, metres));
            if (numbers.isEmpty() || size.isEmpty()) {
                return Optional.empty();
            }
            for (int i = 0; i < columns; i++) {
                vertices[next++] = (float) (size.get()[0] * ((double) i / (columns - 1) - 0.5));
                vertices[next++] = (float) numbers.get()[i];
                vertices[next++] = (float) (size.get()[1] * ((double) j / (rows.size() - 1) - 0.5));
            }
        }
        return Optional.of(
                Mesh.builder(vertices, Relief.triangles(rows.size(), columns))
                        .relief(new Relief(size.get()[0], size.get()[1], Optional.empty()))
                        .build());
    }

    /** Returns the mesh of a terrain whose heights are in a file. */
    private Optional<Shape> relief(Node aspect, Node file) {
        Optional<double[]> size = lengths(aspect, "size", 2);
        Optional<Node> stated = aspect.get("heightRange");
        Optional<double[]> heights =
                stated.flatMap(
                        node ->
                                quantities
                                        .numbers(node, 2, METRE)
                                        .filter(
                                                metres ->
                                                        physics.fits(
                                                                node, ScalarType.F32, metres)));
        if (size.isEmpty() || stated.isPresent() && heights.isEmpty()) {
            return Optional.empty();
        }
        Optional<Relief.Range> range = Optional.empty();
        try {
            range = heights.map(metres -> new Relief.Range(metres[0], metres[1]));
        } catch (IllegalArgumentException refused) {
            problems.add(stated.orElseThrow(), refused.getMessage());
            return Optional.empty();
        }
        var measures = new Relief(size.get()[0], size.get()[1], range);
        return file.text()
                .flatMap(
                        path ->
                                load(
                                        file,
                                        () -> assets.terrain(pathOf.apply(file, path), measures)));
    }

    private Optional<double[]> lengths(Node aspect, String key, int count) {
        return aspect.get(key)
                .flatMap(
                        node ->
                                quantities
                                        .numbers(node, count, METRE)
                                        .filter(metres -> physics.isWorkable(node, metres)));
    }

    private Optional<Shape> file(Node node) {
        return node.text().flatMap(path -> load(node, () -> assets.mesh(pathOf.apply(node, path))));
    }

    private void material(Node node, ItemDefinition.Builder item) {
        double roughness = fraction(node, "roughness", Material.DEFAULT.roughness());
        double metallic = fraction(node, "metallic", Material.DEFAULT.metallic());
        Optional<Texture> texture =
                node.get("texture")
                        .flatMap(
                                path ->
                                        path.text()
                                                .flatMap(
                                                        text ->
                                                                load(
                                                                        path,
                                                                        () ->
                                                                                assets.texture(
                                                                                        pathOf
                                                                                                .apply(
                                                                                                        path,
                                                                                                        text)))));
        Colour colour =
                node.get("colour")
                        .flatMap(Node::text)
                        .filter(text -> text.startsWith("#"))
                        .map(Colour::parse)
                        .orElse(Colour.WHITE);
        attempt(node, () -> item.material(new Material(colour, roughness, metallic, texture)));
    }

    private double fraction(Node material, String key, double otherwise) {
        return material.get(key)
                .flatMap(
                        node ->
                                quantities
                                        .number(node, Unit.ONE)
                                        .filter(
                                                value -> {
                                                    boolean fits = value >= 0 && value <= 1;
                                                    if (!fits) {
                                                        problems.add(
                                                                node,
                                                                key
                                                                        + ": "
                                                                        + value
                                                                        + ", expected 0 to 1");
                                                    }
                                                    return fits;
                                                }))
                .orElse(otherwise);
    }

    private interface Loading<T> {
        T load() throws AssetException;
    }

    private <T> Optional<T> load(Node node, Loading<T> loading) {
        try {
            return Optional.of(loading.load());
        } catch (AssetException refused) {
            problems.add(node, node.label() + ": " + refused.getMessage());
            return Optional.empty();
        }
    }

    private Optional<Shape> mesh(Node vertices, Node triangles) {
        if (!vertices.isList()
                || !triangles.isList()
                || vertices.children().size() < 3
                || triangles.children().isEmpty()) {
            return Optional.empty(); // the schema check has reported the problem
        }
        float[] coordinates = new float[3 * vertices.children().size()];
        int[] indices = new int[3 * triangles.children().size()];
        boolean complete = true;
        int next = 0;
        for (Node vertex : vertices.children()) {
            Optional<double[]> point =
                    quantities
                            .numbers(vertex, 3, METRE)
                            .filter(at -> physics.fits(vertex, ScalarType.F32, at));
            complete &= point.isPresent();
            for (int axis = 0; axis < 3 && point.isPresent(); axis++) {
                coordinates[next++] = (float) point.get()[axis];
            }
        }
        next = 0;
        for (Node triangle : triangles.children()) {
            Optional<double[]> corners =
                    quantities
                            .numbers(triangle, 3, Unit.ONE)
                            .filter(
                                    numbers ->
                                            areVertices(
                                                    triangle, numbers, vertices.children().size()));
            complete &= corners.isPresent();
            for (int corner = 0; corner < 3 && corners.isPresent(); corner++) {
                indices[next++] = (int) corners.get()[corner];
            }
        }
        return complete ? Optional.of(Shape.mesh(coordinates, indices)) : Optional.empty();
    }

    private boolean areVertices(Node triangle, double[] numbers, int vertexCount) {
        for (double number : numbers) {
            if (number != Math.rint(number) || number < 0 || number >= vertexCount) {
                problems.add(
                        triangle,
                        triangle.label()
                                + ": "
                                + number
                                + " is not the number of a vertex, expected 0 to "
                                + (vertexCount - 1));
                return false;
            }
        }
        return true;
    }

    /**
     * Runs a step that throws an exception for wrong values, and records its message as a problem
     * with the value.
     */
    private void attempt(Node node, Runnable step) {
        try {
            step.run();
        } catch (IllegalArgumentException refused) {
            problems.add(node, refused.getMessage());
        }
    }
}
