// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * The items of a world file by name, and the references to them. References are checked when all
 * items are known.
 */
final class ItemMentions {
    private final Problems problems;

    /** Items by name. Only the first of several items with the same name is included. */
    private final Map<String, Entry> byName = new LinkedHashMap<>();

    private final List<Mention> mentions = new ArrayList<>();

    /** Whether references to items that are not in the file are permitted. */
    private boolean others;

    /** References to parents, by the name of the attached item. */
    private final Map<String, Node> parents = new LinkedHashMap<>();

    /** Names of the items whose physics other items cannot refer to, because it may leave. */
    private final Set<String> changing = new HashSet<>();

    /** For each part of a level, the item with this level. */
    private final Map<String, String> parts = new HashMap<>();

    /** The data of an item that are necessary to check references to it. */
    private record Entry(Node name, String kind, boolean hasPhysics) {}

    /** A reference to an item, and the requirements on the item. */
    private record Mention(Node target, String kind, boolean needsPhysics) {}

    ItemMentions(Problems problems) {
        this.problems = problems;
    }

    /**
     * Adds an item.
     *
     * @return false if the name is already in use; this is then recorded as a problem
     */
    boolean add(Node name, String kind, boolean hasPhysics) {
        String text = name.text().orElseThrow();
        Entry first = byName.putIfAbsent(text, new Entry(name, kind, hasPhysics));
        return first == null
                || refuse(
                        name,
                        "duplicate item name `"
                                + Node.shorten(text)
                                + "`, first "
                                + Problems.place(first.name, name));
    }

    /** Refuses references to the physics of an item, because it has levels with parts. */
    void addChanging(String item) {
        changing.add(item);
    }

    /**
     * Adds a part of a level of an item. Other items cannot refer to it.
     *
     * @param name node of the item's name
     * @param part full name of the part
     */
    void addPart(Node name, String part, String kind) {
        String owner = name.text().orElse("");
        if (!owner.equals(parts.put(part, owner))) {
            add(name.withValue(part), kind, true);
        }
    }

    /** Adds a reference, which is resolved when all items are known. */
    void mention(Node target, String kind, boolean needsPhysics) {
        mentions.add(new Mention(target, kind, needsPhysics));
    }

    /** Adds the reference of an item to its parent, like {@link #mention}. */
    void mentionParent(String item, Node parent) {
        parents.put(item, parent);
        mention(parent, WorldPrototype.BODY, false);
    }

    /**
     * Permits references to items that are not in the text. The running world checks these
     * references later, when it executes the edit.
     */
    void permitOthers() {
        others = true;
    }

    /** Resolves all references, and records the problems. Called when all items are known. */
    void resolve() {
        for (Mention mention : mentions) {
            if (problems.full()) {
                break;
            }
            resolve(mention);
        }
        refuseCircles();
        LookAlikes.warn(byName.values().stream().map(Entry::name).toList(), problems);
    }

    /**
     * Returns the names in a list of bodies for agents. Omits bodies that agents cannot take, and
     * records a problem for each of them.
     */
    List<String> bodies(Node list) {
        List<String> names = new ArrayList<>();
        Set<String> seen = new HashSet<>();
        for (Node node : list.children()) {
            node.text()
                    .ifPresent(
                            name -> {
                                if (resolve(new Mention(node, WorldPrototype.BODY, false))
                                        && !seen.add(name)) {
                                    refuse(node, node.label() + ": `" + name + "` is listed twice");
                                }
                                names.add(name);
                            });
        }
        return names;
    }

    /**
     * Returns the name in a node if a body has this name. Otherwise records a problem and returns
     * empty.
     */
    Optional<String> body(Node name) {
        return name.text().filter(text -> resolve(new Mention(name, WorldPrototype.BODY, false)));
    }

    /**
     * Returns the name in a node if a body with a physics aspect has this name. Otherwise records a
     * problem and returns empty.
     */
    Optional<String> physicalBody(Node name) {
        return name.text().filter(text -> resolve(new Mention(name, WorldPrototype.BODY, true)));
    }

    /**
     * Resolves one reference.
     *
     * @return false if no item meets the requirements; this is then recorded as a problem
     */
    private boolean resolve(Mention mention) {
        Node target = mention.target;
        String name = target.text().orElseThrow();
        Entry entry = byName.get(name);
        if (entry == null && others) {
            return true;
        }
        if (entry == null) {
            return refuse(
                    target,
                    target.label()
                            + ": no item is named `"
                            + Node.shorten(name)
                            + "`"
                            + problems.suggestion(name, byName.keySet()));
        }
        if (!entry.kind.equals(mention.kind)) {
            return refuse(
                    target,
                    target.label()
                            + ": `"
                            + name
                            + "` is a "
                            + entry.kind
                            + ", expected a "
                            + mention.kind);
        }
        if (parts.containsKey(name)) {
            return refuse(
                    target,
                    target.label()
                            + ": `"
                            + name
                            + "` is a part of a level of `"
                            + parts.get(name)
                            + "`, which leaves with this level; only parts of the same level can"
                            + " refer to it");
        }
        if (mention.needsPhysics && changing.contains(name)) {
            return refuse(
                    target,
                    target.label()
                            + ": `"
                            + name
                            + "` has a level with parts, so it does not always have physics;"
                            + " expected an item whose levels have no parts");
        }
        return !mention.needsPhysics
                || entry.hasPhysics
                || refuse(
                        target,
                        target.label()
                                + ": `"
                                + name
                                + "` has no `physics`, so nothing "
                                + "can hold on to it; mass 0 makes a body immovable");
    }

    private boolean refuse(Node node, String message) {
        problems.add(node, message);
        return false;
    }

    /**
     * Refuses cycles of parents. In a cycle, items are attached to themselves through any number of
     * parents.
     */
    private void refuseCircles() {
        Set<String> free = new HashSet<>();
        for (String item : parents.keySet()) {
            Set<String> path = new LinkedHashSet<>();
            String next = item;
            while (parents.containsKey(next) && !free.contains(next)) {
                Node parent = parents.get(next);
                if (!path.add(next)) {
                    problems.add(
                            parent,
                            "parent: `"
                                    + Node.shorten(next)
                                    + "` would be its own parent, by way of "
                                    + Node.shorten(String.join(", ", path)));
                    break;
                }
                next = parent.text().orElseThrow();
            }
            free.addAll(path);
        }
    }
}
