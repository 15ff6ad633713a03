// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.WorldPrototype;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Check of prefabs (templates of items) that no item uses yet. It reports errors before the first
 * item uses the prefab. It does not check parts that only an item can complete: formulas,
 * incomplete shapes, and references to items.
 */
final class PrefabCheck {
    private static final List<String> SHAPE_KEYS =
            List.of("shape", "radius", "height", "size", "vertices", "triangles", "file");
    private static final Map<String, Set<String>> WHOLE =
            Map.of(
                    "sphere",
                    Set.of("radius"),
                    "capsule",
                    Set.of("radius", "height"),
                    "cylinder",
                    Set.of("radius", "height"),
                    "box",
                    Set.of("size"),
                    "plane",
                    Set.of("size"),
                    "mesh",
                    Set.of("vertices", "triangles"));

    private final WorldPrototype prototype;

    /** Kinds of items by the names of their physics properties. */
    private final Map<String, String> kinds = new HashMap<>();

    private final ItemReader reader;

    /**
     * Aspects of prefabs. The value of each is the same aspect without the values that contain
     * formulas.
     */
    private final Map<Node, Node> constants = new HashMap<>();

    /**
     * @param reader a separate reader that does not check whether referenced items exist
     */
    PrefabCheck(WorldPrototype prototype, ItemReader reader) {
        this.prototype = prototype;
        prototype.properties().forEach(each -> kinds.put(each.name(), each.kind()));
        this.reader = reader;
    }

    void check(Node prefab) throws WorldFileException {
        Node part = withoutFormulas(prefab);
        if (part.get("physical").filter(PrefabCheck::hasWholeShape).isEmpty()) {
            part = without(without(part, "physical", SHAPE_KEYS), "physics", List.of("density"));
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
     * Returns the prefab without the values that contain formulas. Searches an aspect that several
     * prefabs share only once.
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

    private static boolean hasWholeShape(Node physical) {
        String shape = physical.get("shape").flatMap(Node::text).orElse("");
        return shape.equals("mesh") && physical.get("file").isPresent()
                || WHOLE.containsKey(shape)
                        && WHOLE.get(shape).stream().allMatch(key -> physical.get(key).isPresent());
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

    /**
     * Returns the declared kind of a prefab. If there is none, returns the kind to which most of
     * the prefab's properties belong.
     */
    private String kind(Node prefab) {
        Optional<String> declaredKind = prefab.get("kind").flatMap(Node::text);
        if (declaredKind.isPresent()
                || prefab.get("physical").isPresent()
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
