// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ClassHierarchy;
import reve.core.world.ItemClass;
import reve.core.world.WorldPrototype;

import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Completes the physics aspect of items with the initial values of their classes. Also checks the
 * classes that items name.
 */
final class ClassValues {
    private static final List<String> OF_MASS =
            List.of(WorldPrototype.MASS, ItemClass.DENSITY, "inertia");

    private final ClassHierarchy classes;
    private final Problems problems;

    /** Completed aspects. Items that share a prefab share the aspect of this prefab. */
    private final Map<Shared, Node> shared = new HashMap<>();

    /** Undeclared classes that were reported. */
    private final Set<String> reported = new HashSet<>();

    /** Shapes without a volume. Such items of a substance are immovable. */
    private static final Set<String> SURFACES = Set.of("plane", "terrain");

    private record Shared(Node aspect, String itemClass, boolean isChild, boolean isSurface) {}

    ClassValues(WorldPrototype prototype, Problems problems) {
        this.classes = prototype.classes();
        this.problems = problems;
    }

    /** Returns whether the world declares classes. */
    boolean areDeclared() {
        return !classes.isEmpty();
    }

    /**
     * Returns an item whose physics aspect contains the initial values of its class. An item
     * without the key {@code physics} gets none.
     */
    Node complete(Node item, String kind) {
        if (classes.isEmpty()) {
            return item;
        }
        Optional<Node> aspect = item.get("physics").filter(Node::isMapping);
        String name = name(item).flatMap(Node::text).orElse("");
        Map<String, List<Double>> values = classes.properties(name);
        if (aspect.isEmpty() || values.isEmpty() || !classes.kind(name).equals(Optional.of(kind))) {
            return item;
        }
        boolean isChild = item.get("parent").isPresent();
        boolean isSurface =
                item.get("physical")
                        .flatMap(physical -> physical.get("shape"))
                        .flatMap(Node::text)
                        .filter(SURFACES::contains)
                        .isPresent();
        Node completed =
                aspect.get().isWrittenIn(item)
                        ? completed(aspect.get(), values, isChild, isSurface)
                        : shared.computeIfAbsent(
                                new Shared(aspect.get(), name, isChild, isSurface),
                                key -> completed(key.aspect, values, isChild, isSurface));
        Map<String, Node> fields = new LinkedHashMap<>();
        item.children().forEach(each -> fields.put(each.key(), each));
        fields.put("physics", completed);
        return item.withValue(fields);
    }

    private static Node completed(
            Node own, Map<String, List<Double>> values, boolean isChild, boolean isSurface) {
        boolean isImmovable = isSurface && values.containsKey(WorldPrototype.SUBSTANCE);
        boolean hasOwnMass =
                isChild
                        || own.get(WorldPrototype.MASS).isPresent()
                        || own.get(ItemClass.DENSITY).isPresent()
                        || own.get(WorldPrototype.SUBSTANCE)
                                .filter(substance -> substance.text().isPresent())
                                .isPresent();
        Map<String, Node> fields = new LinkedHashMap<>();
        values.entrySet().stream()
                .sorted(Map.Entry.comparingByKey())
                .filter(each -> !hasOwnMass || !OF_MASS.contains(each.getKey()))
                .filter(each -> !isImmovable || !each.getKey().equals(ItemClass.DENSITY))
                .forEach(each -> fields.put(each.getKey(), node(own, each)));
        return own.over(own.withValue(fields));
    }

    private static Node node(Node aspect, Map.Entry<String, List<Double>> value) {
        double[] numbers = value.getValue().stream().mapToDouble(Double::doubleValue).toArray();
        Node node =
                numbers.length == 1 ? aspect.withValue(numbers[0]) : aspect.withNumbers(numbers);
        return node.as(aspect, value.getKey());
    }

    /** Returns the node with the class of an item. */
    static Optional<Node> name(Node item) {
        return item.get("semantic").flatMap(semantic -> semantic.get("class"));
    }

    /**
     * Refuses a class of another kind. Warns once of each class that the world does not declare, if
     * it declares others.
     */
    void check(Node item, String kind) {
        Optional<Node> node = name(item);
        Optional<String> name = node.flatMap(Node::text);
        if (classes.isEmpty() || name.isEmpty()) {
            return;
        }
        Optional<String> expected = classes.kind(name.get());
        if (expected.filter(other -> !other.equals(kind)).isPresent()) {
            problems.add(
                    node.get(),
                    "class: a "
                            + Node.shorten(name.get())
                            + " is a "
                            + expected.get()
                            + ", the item is a "
                            + kind);
        } else if (expected.isEmpty()) {
            warn(node.get(), name.get(), kind);
        }
    }

    /** Warns once of a class that the world does not declare, if it declares others. */
    void warn(Node where, String name, String kind) {
        if (classes.isEmpty()
                || classes.find(name).isPresent()
                || name.equals(kind)
                || !reported.add(name)) {
            return;
        }
        String suggestion =
                problems.suggestion(name, classes.all().stream().map(ItemClass::name).toList());
        problems.warn(
                where,
                "class: `"
                        + Node.shorten(name)
                        + "` is not one of the classes that the world declares"
                        + (suggestion.isEmpty() ? "; declare it under `classes`" : suggestion));
    }
}
