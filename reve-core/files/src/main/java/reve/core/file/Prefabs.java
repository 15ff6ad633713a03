// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;

/**
 * The prefabs of a world file by name. A prefab is a template. An item with the key {@code like}
 * takes the values of this prefab.
 */
final class Prefabs {
    /** Maximum length of a chain of prefabs in which each prefab is {@code like} the next one. */
    static final int MAX_CHAIN = 32;

    private final Problems problems;
    private final Expansion.Room values;
    private final Map<String, Node> given = new LinkedHashMap<>();
    private final Map<String, Node> complete = new HashMap<>();

    /** Names of prefabs that an item or an agent's body uses. */
    private final Set<String> used = new HashSet<>();

    /**
     * @param prefabs nodes whose keys are the names of the prefabs; if several have the same name,
     *     the first one is used
     * @param values limit on the values that the completion of items creates
     */
    Prefabs(List<Node> prefabs, Problems problems, Expansion.Room values)
            throws WorldFileException {
        this.problems = problems;
        this.values = values;
        for (Node prefab : prefabs) {
            Node first = given.putIfAbsent(prefab.key(), prefab);
            if (first != null) {
                problems.addAtKey(
                        prefab,
                        "duplicate prefab `"
                                + Node.shorten(prefab.key())
                                + "`, first "
                                + Problems.place(first, prefab));
            }
        }
        for (Node prefab : given.values()) {
            prefab(prefab, prefab.key(), new LinkedHashSet<>());
        }
    }

    /** Returns an item completed with the values of its prefab, if it has one. */
    Node complete(Node item) throws WorldFileException {
        item.get("like").flatMap(Node::text).ifPresent(used::add);
        return complete(item, new LinkedHashSet<>());
    }

    /** Returns a completed prefab. Does not count as use of the prefab. */
    Optional<Node> find(String name) {
        return Optional.ofNullable(complete.get(name));
    }

    /** Returns the completed prefabs that no item uses, directly or through other prefabs. */
    List<Node> unused() {
        Set<String> reached = new HashSet<>();
        for (String name : used) {
            Optional<Node> next = Optional.ofNullable(given.get(name));
            while (next.isPresent() && reached.add(next.get().key())) {
                next = next.get().get("like").flatMap(Node::text).map(given::get);
            }
        }
        return given.keySet().stream()
                .filter(name -> !reached.contains(name))
                .map(complete::get)
                .filter(Objects::nonNull)
                .filter(Node::isMapping)
                .toList();
    }

    /**
     * Returns an item or prefab completed with the values of its prefab.
     *
     * @param users names of the prefabs that are being completed, each {@code like} the next one;
     *     used to find cycles
     */
    private Node complete(Node item, Set<String> users) throws WorldFileException {
        Optional<Node> like = item.get("like");
        if (like.flatMap(Node::text).isEmpty()) {
            return item;
        }
        Optional<Node> prefab = prefab(like.get(), like.get().text().orElseThrow(), users);
        Node own = item.without("like");
        if (prefab.filter(Node::isMapping).isEmpty()) {
            return own;
        }
        values.require(prefab.get().fieldCount(), item);
        return own.over(prefab.get());
    }

    /**
     * Returns the completed prefab of a name.
     *
     * @param where node that contains the name, for the problem if there is no such prefab
     */
    private Optional<Node> prefab(Node where, String name, Set<String> users)
            throws WorldFileException {
        Node known = complete.get(name);
        Node prefab = given.get(name);
        if (known != null || prefab == null) {
            if (prefab == null) {
                problems.add(
                        where,
                        "like: there is no prefab `"
                                + Node.shorten(name)
                                + "`"
                                + problems.suggestion(name, given.keySet()));
            }
            return Optional.ofNullable(known);
        }
        if (users.size() == MAX_CHAIN || !users.add(name)) {
            problems.add(
                    where,
                    "like: "
                            + (users.size() == MAX_CHAIN
                                    ? "more than "
                                            + MAX_CHAIN
                                            + " prefabs of which each is like the next"
                                    : "prefabs are like each other in a circle: "
                                            + String.join(", ", users)
                                            + ", "
                                            + name));
            return Optional.empty();
        }
        Node whole = complete(prefab, users);
        users.remove(name);
        complete.put(name, whole);
        return Optional.of(whole);
    }
}
