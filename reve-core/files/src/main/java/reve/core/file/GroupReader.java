// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;
import reve.core.world.PropertyDescriptor;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/**
 * Reader of groups. A group is an item with the key {@code parts}. It creates the items of its
 * parts, and no item of its own. The name of such an item consists of the name of the group, a dot,
 * and the name of the part.
 */
final class GroupReader {
    /** The key of the parts. */
    static final String PARTS = "parts";

    /** Maximum depth of groups that are parts of groups. */
    static final int MAX_DEPTH = 8;

    private static final String SEPARATOR = ".";
    private static final Set<String> PLACE = Set.of("location", "orientation");

    private final WorldPrototype prototype;
    private final Expansion expansion;
    private final PhysicalReader physical;
    private final Problems problems;
    private final Sink sink;

    /** A receiver of the items of groups. */
    interface Sink {
        /**
         * Receives an item with its full name, and full names of other parts.
         *
         * @param placement the place of its group
         */
        void accept(Node item, Placement placement) throws WorldFileException;
    }

    GroupReader(
            WorldPrototype prototype,
            Expansion expansion,
            PhysicalReader physical,
            Problems problems,
            Sink sink) {
        this.prototype = prototype;
        this.expansion = expansion;
        this.physical = physical;
        this.problems = problems;
        this.sink = sink;
    }

    /** Returns whether an item is a group. */
    static boolean isGroup(Node item) {
        return item.get(PARTS).isPresent();
    }

    /** Reads the items of a group that is not a part of another group. */
    void read(Node group) throws WorldFileException {
        read(group, Placement.NONE, new Scope(Optional.empty(), "", Set.of()), 1);
    }

    /**
     * The parts of a group that may refer to each other.
     *
     * @param outer the group of which this group is a part
     * @param prefix beginning of the full names of the parts
     * @param names names of the parts without the prefix
     */
    private record Scope(Optional<Scope> outer, String prefix, Set<String> names) {
        /**
         * Returns the full name of the part that a name means. Returns the name itself if it means
         * no part, but an item of the world.
         */
        String resolve(String name) {
            int end = name.indexOf(SEPARATOR);
            boolean isPart = names.contains(name);
            while (!isPart && end >= 0) { // a part of a group that is a part
                isPart = names.contains(name.substring(0, end));
                end = name.indexOf(SEPARATOR, end + 1);
            }
            return isPart ? prefix + name : outer.map(scope -> scope.resolve(name)).orElse(name);
        }
    }

    private void read(Node group, Placement place, Scope outer, int depth)
            throws WorldFileException {
        Optional<String> name = group.get("name").flatMap(Node::text);
        refuseOtherKeys(group);
        if (depth > MAX_DEPTH) {
            problems.add(
                    group,
                    PARTS
                            + ": more than "
                            + MAX_DEPTH
                            + " groups of which each is a part of the one before; a prefab cannot"
                            + " be a part of itself");
            return;
        }
        if (name.isEmpty()) {
            return;
        }
        Placement placement = place.of(Placement.of(place(group)));
        List<Node> items = parts(group);
        Set<String> names = new HashSet<>();
        items.forEach(item -> item.get("name").flatMap(Node::text).ifPresent(names::add));
        var scope = new Scope(Optional.of(outer), name.get() + SEPARATOR, names);
        for (Node item : items) {
            if (problems.full()) {
                return;
            }
            Node named = withFullNames(item, scope);
            if (isGroup(named)) {
                read(named, placement, scope, depth + 1);
            } else {
                sink.accept(named, placement);
            }
        }
    }

    private void refuseOtherKeys(Node group) {
        for (Node value : group.children()) {
            boolean isPlace = value.key().equals("physical");
            if (!isPlace && !value.key().equals(PARTS) && !value.key().equals("name")) {
                refuse(value, value.key());
            }
            for (Node inner : isPlace ? value.children() : List.<Node>of()) {
                if (!PLACE.contains(inner.key())) {
                    refuse(inner, inner.key());
                }
            }
        }
    }

    private void refuse(Node value, String key) {
        problems.addAtKey(
                value,
                "`"
                        + key
                        + "` does not go with `parts`: a group has only a name and, in `physical`, a"
                        + " location and an orientation; write it into one of the parts");
    }

    /** Reads the location and the orientation of a group. */
    private ItemDefinition place(Node group) {
        ItemDefinition.Builder place = ItemDefinition.kept("group");
        for (Node value : group.get("physical").map(Node::children).orElse(List.of())) {
            if (PLACE.contains(value.key())) {
                physical.readPlaceOrColour(value, place);
            }
        }
        return place.build();
    }

    /** Returns the parts, completed from their prefabs, with all of their repetitions. */
    private List<Node> parts(Node group) throws WorldFileException {
        List<Node> parts = new ArrayList<>();
        for (Node part : group.get(PARTS).orElseThrow().children()) {
            if (part.isMapping()) {
                parts.add(named(part, part.key()));
            }
        }
        List<Node> items = new ArrayList<>();
        var collector =
                new Expansion.Sink() {
                    @Override
                    public void accept(Node item) throws WorldFileException {
                        expansion.requireValues(item);
                        items.add(item);
                    }

                    @Override
                    public void accept(Template item, Repetition repetition) {
                        for (long n = 0; n < repetition.count() && !problems.full(); n++) {
                            items.add(item.make(repetition.values().at(n), n));
                        }
                    }
                };
        for (Node part : parts) {
            expansion.expand(part, collector);
        }
        return items;
    }

    /** Returns an item with a name, which has the position of the item's key. */
    static Node named(Node item, String name) {
        Map<String, Node> fields = new LinkedHashMap<>();
        Node named = item.withValue(fields);
        new Node.Slot(named, "name", item.keyLine(), item.keyColumn())
                .fill(item.keyLine(), item.keyColumn(), name);
        item.children().forEach(value -> fields.putIfAbsent(value.key(), value));
        return named;
    }

    /** Returns a part whose name, parent and references are names of items of the world. */
    private Node withFullNames(Node part, Scope scope) {
        Map<String, Node> fields = new LinkedHashMap<>();
        Node renamed = part.withValue(fields);
        for (Node value : part.children()) {
            fields.put(
                    value.key(),
                    switch (value.key()) {
                        case "name" -> value.withValue(scope.prefix + value.text().orElse(""));
                        case "parent" -> resolved(value, scope);
                        case "physics" -> withReferences(value, part, renamed, scope);
                        default -> value;
                    });
        }
        return renamed;
    }

    private Node withReferences(Node physics, Node part, Node owner, Scope scope) {
        String kind = part.get("kind").flatMap(Node::text).orElse(WorldPrototype.BODY);
        List<String> references =
                prototype.hasKind(kind)
                        ? prototype.references(kind).stream().map(PropertyDescriptor::name).toList()
                        : List.of();
        if (references.stream().noneMatch(name -> physics.get(name).isPresent())) {
            return physics;
        }
        Map<String, Node> fields = new LinkedHashMap<>();
        for (Node value : physics.children()) {
            fields.put(
                    value.key(), references.contains(value.key()) ? resolved(value, scope) : value);
        }
        return physics.withValue(fields).as(owner, "physics");
    }

    private static Node resolved(Node value, Scope scope) {
        return value.isList()
                ? value.withValue(
                        new ArrayList<>(
                                value.children().stream()
                                        .map(each -> resolved(each, scope))
                                        .toList()))
                : value.text().map(name -> value.withValue(scope.resolve(name))).orElse(value);
    }
}
