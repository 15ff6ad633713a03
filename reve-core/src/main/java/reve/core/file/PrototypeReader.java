// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.unit.Unit;
import reve.core.world.PropertyDescriptor;
import reve.core.world.ScalarType;
import reve.core.world.WorldPrototype;

import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/** Reads {@code prototype} and {@code properties}: which properties the items of a world have. */
final class PrototypeReader {
    /** Most properties of one world. */
    static final int MAX_PROPERTIES = 1000;

    private final Problems problems;
    private final Quantities quantities;
    private final Set<String> misdeclared = new HashSet<>();

    PrototypeReader(Problems problems) {
        this.problems = problems;
        this.quantities = new Quantities(problems);
    }

    /** The standard prototype that the file names, with the properties that are declared. */
    WorldPrototype read(Node root, List<Node> properties) throws WorldFileException {
        problems.requireAtMost(MAX_PROPERTIES, properties, "properties");
        WorldPrototype prototype = standard(root);
        for (Node property : properties) {
            prototype = extend(prototype, property);
        }
        return prototype;
    }

    /** Names of the properties whose declaration was refused. */
    Set<String> misdeclared() {
        return misdeclared;
    }

    /** The unit under the key {@code unit}, else 1; empty and a problem if it is wrong. */
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

    /** The number under the key {@code components}, else 1; the schema reports wrong ones. */
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
