// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** Which items a world file has, by name, and where it mentions them. */
final class ItemNames {
    private final Problems problems;

    /** Of several items with one name, the first. */
    private final Map<String, Entry> byName = new LinkedHashMap<>();

    private final List<Mention> mentions = new ArrayList<>();

    /** Where items name their parents, by the items' names. */
    private final Map<String, Node> parents = new LinkedHashMap<>();

    /** What others may ask about an item. */
    private record Entry(Node name, String kind, boolean hasPhysics) {}

    /** One mention of an item, and what it has to be. */
    private record Mention(Node target, String kind, boolean needsPhysics) {}

    ItemNames(Problems problems) {
        this.problems = problems;
    }

    /** An item of that name. @return false and a problem noted if there is one already */
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

    /** To be resolved when all items are known. */
    void mention(Node target, String kind, boolean needsPhysics) {
        mentions.add(new Mention(target, kind, needsPhysics));
    }

    /** As {@link #mention}, of the body that an item moves with. */
    void mentionParent(String item, Node parent) {
        parents.put(item, parent);
        mention(parent, WorldPrototype.BODY, false);
    }

    /** All items are known: notes problems of what mentions are of. */
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

    /** The names of bodies in a list that agents may take; problems of others are noted. */
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

    /** The name of a body that takes part in physics; empty and a problem noted for any other. */
    Optional<String> physicalBody(Node name) {
        return name.text().filter(text -> resolve(new Mention(name, WorldPrototype.BODY, true)));
    }

    /**
     * @return false and a problem noted if it is of no item that is as it should be
     */
    private boolean resolve(Mention mention) {
        Node target = mention.target;
        String name = target.text().orElseThrow();
        Entry entry = byName.get(name);
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

    /** Nothing is its own parent, however far up. */
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
