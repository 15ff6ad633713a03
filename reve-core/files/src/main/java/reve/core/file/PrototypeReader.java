// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.WorldPrototype;

import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Reader of the keys {@code prototype} and {@code properties}, which define the properties that the
 * world's items have.
 */
final class PrototypeReader {
    /** Maximum number of properties of one world. */
    static final int MAX_PROPERTIES = 1000;

    /** Keys with long lists of numbers. The search for properties skips them. */
    private static final Set<String> MESH_KEYS = Set.of("vertices", "triangles", "heights");

    /**
     * Properties that a law writes for each body, by the property that requests them. A world with
     * an item that sets the first property also gets the second one.
     */
    private static final Map<String, String> WRITTEN_WITH = Map.of("touchSensor", "touchCount");

    private static final Pattern PHYSICS_NAME = Pattern.compile("\\bphysics\\.(\\w+)");

    private final Problems problems;
    private final Quantities quantities;
    private final Set<String> misdeclared = new HashSet<>();

    PrototypeReader(Problems problems) {
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /**
     * Returns the standard prototype that the file names, together with the declared properties.
     *
     * @param parts the parts of the files that may contain the kind {@code joint} or sensors:
     *     items, prefabs, agents and rules
     */
    WorldPrototype read(Node root, List<Node> properties, List<Node> parts)
            throws WorldFileException {
        problems.requireAtMost(MAX_PROPERTIES, properties, "properties");
        WorldPrototype prototype = standard(root);
        boolean ownJoints = properties.stream().anyMatch(PrototypeReader::isOfJoints);
        if (!ownJoints && parts.stream().anyMatch(PrototypeReader::hasJoints)) {
            prototype = prototype.withJoints();
        }
        prototype = withPropertiesOnDemand(prototype, properties, parts);
        for (Node property : properties) {
            if (property.get("name").flatMap(Node::text).filter(misdeclared::contains).isEmpty()) {
                prototype = extend(prototype, property);
            }
        }
        return prototype;
    }

    /**
     * Adds the properties on demand that items set or that rules of joints read. Omits those that
     * the file declares.
     */
    private WorldPrototype withPropertiesOnDemand(
            WorldPrototype prototype, List<Node> properties, List<Node> parts) {
        Set<String> set = new HashSet<>();
        Set<String> measured = new HashSet<>();
        for (Node part : parts) {
            findProperties(part, set, measured);
        }
        set.addAll(measured);
        WRITTEN_WITH.forEach(
                (property, written) -> {
                    if (set.contains(property)) {
                        set.add(written);
                    }
                });
        for (Node property : properties) {
            Optional<String> name = property.get("name").flatMap(Node::text);
            name.ifPresent(set::remove);
            if (name.filter(measured::contains).isPresent()) {
                problems.add(
                        property.get("name").orElseThrow(),
                        name.get()
                                + ": a sensor of this world measures the property of this name;"
                                + " choose another name");
                misdeclared.add(name.get());
                set.add(name.get());
            }
        }
        return prototype.extendedBy(
                prototype.propertiesOnDemand().stream()
                        .filter(property -> set.contains(property.name()))
                        .filter(property -> prototype.hasKind(property.kind()))
                        .toList());
    }

    /**
     * Adds the keys of all mappings under the key {@code physics} in a node. Also adds the names
     * after {@code physics.} in the rules of joints.
     *
     * @param measured receives the names of the properties that instruments measure
     */
    private static void findProperties(Node node, Set<String> found, Set<String> measured) {
        if (node.key().equals("physics") && node.isMapping()) {
            node.children().forEach(value -> found.add(value.key()));
        } else if (isOfJoints(node) && node.get("is").isPresent()) {
            Matcher names = PHYSICS_NAME.matcher(node.get("is").flatMap(Node::text).orElse(""));
            while (names.find()) {
                found.add(names.group(1));
            }
        } else if (node.key().equals("sensors") && node.isMapping()) {
            node.children().forEach(sensor -> measured.addAll(InstrumentReader.measured(sensor)));
        } else if (!MESH_KEYS.contains(node.key())) {
            node.children().forEach(child -> findProperties(child, found, measured));
        }
    }

    private static boolean isOfJoints(Node node) {
        return node.get("kind").flatMap(Node::text).equals(Optional.of(WorldPrototype.JOINT));
    }

    /** Returns whether a node or a nested node is an item or a rule of the kind {@code joint}. */
    private static boolean hasJoints(Node node) {
        if (isOfJoints(node)) {
            return true;
        }
        return !MESH_KEYS.contains(node.key())
                && node.children().stream().anyMatch(PrototypeReader::hasJoints);
    }

    /** Returns the names of the properties whose declaration was refused. */
    Set<String> misdeclared() {
        return misdeclared;
    }

    /**
     * Returns the unit under the key {@code unit}, or the unit 1 if the key is missing. If the unit
     * is wrong, records a problem and returns empty.
     */
    static Optional<Unit> unit(Node owner, Problems problems) {
        Optional<Node> node = owner.get("unit");
        if (node.isEmpty()) {
            return Optional.of(Unit.ONE);
        }
        try {
            return node.get().scalar().map(Object::toString).map(Unit::parse);
        } catch (IllegalArgumentException notAUnit) {
            problems.add(node.get(), notAUnit.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Returns the number under the key {@code components}, or 1 if it is missing or wrong. The
     * schema check reports a wrong number.
     */
    static int components(Node owner) {
        return Math.clamp(
                owner.get("components").flatMap(Node::number).orElse(1.0).longValue(),
                1,
                PropertyDescriptor.MAX_COMPONENTS);
    }

    private static WorldPrototype standard(Node root) {
        boolean single = root.get("prototype").flatMap(Node::text).equals(Optional.of("si-f32"));
        return WorldPrototype.standard(single ? "si-f32" : "si-f64");
    }

    private double minimum(Node property, Unit unit) {
        return property.get("min")
                .flatMap(node -> quantities.number(node, unit))
                .orElse(Double.NEGATIVE_INFINITY);
    }

    private WorldPrototype extend(WorldPrototype prototype, Node node) {
        Optional<String> name = node.get("name").flatMap(Node::text);
        Optional<String> kind = node.get("kind").flatMap(Node::text);
        Optional<Unit> unit = unit(node, problems);
        if (name.isEmpty() || kind.isEmpty() || unit.isEmpty()) {
            name.ifPresent(misdeclared::add);
            return prototype;
        }
        ScalarType type =
                switch (node.get("type").flatMap(Node::text).orElse("real")) {
                    case "i32" -> ScalarType.I32;
                    case "u32" -> ScalarType.U32;
                    default -> prototype.realType();
                };
        try {
            return prototype.extendedBy(
                    List.of(
                            new PropertyDescriptor(
                                    name.get(),
                                    kind.get(),
                                    type,
                                    components(node),
                                    unit.get(),
                                    Optional.empty(),
                                    minimum(node, unit.get()),
                                    node.get("doc").flatMap(Node::text).orElse(""))));
        } catch (IllegalArgumentException refused) {
            problems.add(node.get("name").orElseThrow(), refused.getMessage());
            misdeclared.add(name.get());
            return prototype;
        }
    }
}
