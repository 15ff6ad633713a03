// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ConnectionLook;
import reve.core.world.WorldPrototype;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Check of prefabs (templates of items) that no item uses yet. It reports errors before the first
 * item uses the prefab. It does not check parts that only an item can complete: formulas,
 * incomplete shapes, and references to items.
 */
final class PrefabCheck {
    private static final List<String> MASS_KEYS = List.of("density", WorldPrototype.SUBSTANCE);

    private final WorldPrototype prototype;

    /** Kinds of items by the names of their physics properties. */
    private final Map<String, String> kinds = new HashMap<>();

    private final ItemReader reader;

    /** For each aspect of a prefab, the same aspect without the values that contain formulas. */
    private final Map<Node, Node> constants = new HashMap<>();

    /**
     * @param reader the reader of the prefabs' items. It must not check whether referenced items
     *     exist, because no item uses the prefabs yet.
     */
    PrefabCheck(WorldPrototype prototype, ItemReader reader) {
        this.prototype = prototype;
        prototype.properties().forEach(each -> kinds.put(each.name(), each.kind()));
        this.reader = reader;
    }

    /**
     * Checks a prefab. Checks each part of a group like a prefab.
     *
     * @param completion completes the parts from their prefabs
     */
    void check(Node prefab, ItemReader.Completion completion) throws WorldFileException {
        for (Node part : prefab.get(GroupReader.PARTS).map(Node::children).orElse(List.of())) {
            if (part.isMapping()) {
                check(completion.complete(part).without(GroupReader.PARTS), completion);
            }
        }
        for (Node level : prefab.get(LevelReader.LEVELS).map(Node::children).orElse(List.of())) {
            if (level.isMapping()) {
                check(completion.complete(level.without(LevelReader.WHEN)), completion);
            }
        }
        Node part = withoutFormulas(prefab.without(GroupReader.PARTS).without(LevelReader.LEVELS));
        if (part.get("physical").filter(PhysicalReader::hasWholeShape).isEmpty()) {
            part =
                    without(
                            without(part, "physical", PhysicalReader.SHAPE_KEYS),
                            "physics",
                            MASS_KEYS);
            part = without(part, "physical", List.of("material"));
        }
        for (Node action : part.get("access").map(Node::children).orElse(List.of())) {
            if (action.get("effects").isEmpty() && action.get("java").isEmpty()) {
                part = without(part, "access", List.of(action.key()));
            }
        }
        reader.readPart(part, kind(part));
    }

    /**
     * Returns the prefab without the values that contain formulas. An aspect that several prefabs
     * share is searched only once.
     */
    private Node withoutFormulas(Node prefab) {
        Map<String, Node> fields = new LinkedHashMap<>();
        for (Node value : prefab.children()) {
            if (value.isMapping()) {
                fields.put(
                        value.key(), constants.computeIfAbsent(value, Template::withoutFormulas));
            } else if (!Template.hasFormula(value)) {
                fields.put(value.key(), value);
            }
        }
        return prefab.withValue(fields);
    }

    private static Node without(Node item, String aspect, List<String> keys) {
        Optional<Node> mapping = item.get(aspect).filter(Node::isMapping);
        if (mapping.isEmpty()) {
            return item;
        }
        Node left = mapping.get();
        for (String key : keys) {
            left = left.without(key);
        }
        Map<String, Node> fields = new LinkedHashMap<>();
        for (Node child : item.children()) {
            fields.put(child.key(), child.key().equals(aspect) ? left : child);
        }
        return item.withValue(fields);
    }

    /** Returns whether a physical aspect has a key that springs and surfaces do not have. */
    private static boolean isOfBody(Node physical) {
        return physical.children().stream()
                .anyMatch(value -> !PhysicalReader.CONNECTION_KEYS.contains(value.key()));
    }

    /**
     * Returns the declared kind of a prefab. Returns the kind to which most of the prefab's
     * properties belong if no kind is declared.
     */
    private String kind(Node prefab) {
        Optional<String> declaredKind = prefab.get("kind").flatMap(Node::text);
        Optional<Node> physical = prefab.get("physical");
        if (declaredKind.isEmpty()
                && physical.flatMap(aspect -> aspect.get(ConnectionLook.WIDTH)).isPresent()) {
            return WorldPrototype.SPRING;
        }
        if (declaredKind.isPresent()
                || physical.filter(PrefabCheck::isOfBody).isPresent()
                || prefab.get("sensors").isPresent()
                || prefab.get("voice").isPresent()
                || prefab.get("physics").isEmpty()) {
            return declaredKind.orElse(WorldPrototype.BODY);
        }
        Map<String, Integer> known = new HashMap<>();
        for (Node value : prefab.get("physics").orElseThrow().children()) {
            String kind = kinds.get(value.key());
            if (kind != null) {
                known.merge(kind, 1, Integer::sum);
            }
        }
        String best = WorldPrototype.BODY;
        for (String kind : known.isEmpty() ? List.<String>of() : prototype.kinds()) {
            if (known.getOrDefault(kind, 0) > known.getOrDefault(best, 0)) {
                best = kind;
            }
        }
        return best;
    }
}
