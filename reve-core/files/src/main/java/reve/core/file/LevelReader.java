// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.rule.Expression;
import reve.core.rule.ExpressionException;
import reve.core.rule.ExpressionType;
import reve.core.rule.LevelRule;
import reve.core.rule.Scope;
import reve.core.text.Rounded;
import reve.core.text.Suggestion;
import reve.core.world.ItemDefinition;
import reve.core.world.Level;
import reve.core.world.LevelCondition;
import reve.core.world.Pose;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;

/**
 * Reader of the key {@code levels} of an item: several physical descriptions, of which one is
 * active.
 */
final class LevelReader {
    /** The key of the levels. */
    static final String LEVELS = "levels";

    /** The key of the condition of a level. */
    static final String WHEN = "when";

    /** Maximum number of different conditions in one file or message. */
    static final int MAX_CONDITIONS = 256;

    /**
     * Maximum number of parts of a level, with their repetitions. Stores and saved worlds contain
     * these parts one by one, and a file may contain this number of parts of a group.
     */
    static final int MAX_PARTS = 1000;

    /** Maximum difference between the masses of two levels, as a fraction of the mass. */
    private static final double MASS_TOLERANCE = 1e-3;

    private static final Set<String> OF_A_LEVEL = Set.of("name", "physical", "physics");
    private static final Set<String> PLACE = Set.of("location", "orientation");

    private final WorldPrototype prototype;
    private final Problems problems;
    private final Doubts doubts;
    private final Reading reading;
    private final Set<String> conditions = new HashSet<>();
    private Optional<Scope> scope = Optional.empty();

    /** A reader of the items of one level. */
    interface Reading {
        /**
         * Returns the item, or the parts of a group, which refer to each other only.
         *
         * @param content an item with a name
         */
        List<ItemDefinition> read(Node content) throws WorldFileException;
    }

    LevelReader(WorldPrototype prototype, Reading reading, Doubts doubts, Problems problems) {
        this.prototype = prototype;
        this.reading = reading;
        this.doubts = doubts;
        this.problems = problems;
    }

    /** Returns whether an item has levels. */
    static boolean hasLevels(Node item) {
        return item.get(LEVELS).isPresent();
    }

    /**
     * Returns whether an item with levels is described as it is at its active level, as in a saved
     * world. Its parts are then other items of the file.
     */
    static boolean isComplete(Node item) {
        return item.get("parent").isPresent()
                || item.get("physics").filter(aspect -> !aspect.children().isEmpty()).isPresent();
    }

    /**
     * Reads the levels of an item. Omits levels with problems.
     *
     * @param name name of the item
     */
    List<Level> read(Node item, String name) throws WorldFileException {
        List<Level> levels = new ArrayList<>();
        for (Node node : item.get(LEVELS).orElseThrow().children()) {
            if (problems.full()) {
                return levels;
            }
            if (node.isMapping()) {
                readLevel(node, name).ifPresent(level -> add(level, node, levels));
            }
        }
        return levels;
    }

    private void add(Level level, Node node, List<Level> levels) {
        if (!levels.isEmpty() && doubts == Doubts.REFUSED) {
            Level first = levels.getFirst();
            double difference = Math.abs(level.mass() - first.mass());
            if (!(difference <= MASS_TOLERANCE * first.mass())) {
                problems.addAtKey(
                        node,
                        level.name()
                                + ": has the mass "
                                + Rounded.of(level.mass())
                                + " kg, but the level `"
                                + first.name()
                                + "` has "
                                + Rounded.of(first.mass())
                                + " kg; expected the same mass, within a thousandth of it");
            }
        }
        levels.add(level);
    }

    /** Refuses keys of an item that do not go with levels. */
    void refuseOtherKeys(Node item) {
        Optional<Node> kind = item.get("kind").filter(node -> !isBody(node));
        kind.ifPresent(
                node ->
                        problems.add(
                                node, "kind: only items of kind body have levels; see `levels`"));
        item.get(GroupReader.PARTS)
                .ifPresent(
                        parts ->
                                problems.addAtKey(
                                        parts,
                                        "`parts` does not go with `levels`; write the parts into one"
                                                + " of the levels"));
        if (isComplete(item)) {
            return;
        }
        for (Node value : item.get("physical").map(Node::children).orElse(List.of())) {
            if (!PLACE.contains(value.key())) {
                problems.addAtKey(
                        value,
                        "`"
                                + value.key()
                                + "` does not go with `levels`: beside them, `physical` has only a"
                                + " location and an orientation; write it into the levels");
            }
        }
    }

    private static boolean isBody(Node kind) {
        return kind.text().filter(WorldPrototype.BODY::equals).isPresent();
    }

    private Optional<Level> readLevel(Node node, String name) throws WorldFileException {
        List<ItemDefinition> items = reading.read(GroupReader.named(node.without(WHEN), name));
        Optional<LevelCondition> when = node.get(WHEN).flatMap(this::condition);
        boolean isGroup = !(items.size() == 1 && items.getFirst().name().equals(name));
        if (items.size() > MAX_PARTS) {
            problems.addAtKey(
                    node,
                    node.key()
                            + ": has "
                            + items.size()
                            + " parts with their repetitions, expected at most "
                            + MAX_PARTS);
            return Optional.empty();
        }
        String prefix = Level.prefix(name);
        try {
            return items.isEmpty()
                    ? Optional.empty()
                    : Optional.of(
                            new Level(
                                    node.key(),
                                    isGroup,
                                    isGroup
                                            ? items.stream()
                                                    .map(each -> Level.relative(prefix, each))
                                                    .toList()
                                            : items,
                                    when));
        } catch (IllegalArgumentException refused) {
            problems.addAtKey(node, refused.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Refuses keys of a level that belong to the item, and a place of a level that is not a group.
     * The reader of groups checks the keys of groups.
     */
    void check(Node content) {
        if (GroupReader.isGroup(content)) {
            return;
        }
        for (Node value : content.children()) {
            if (!OF_A_LEVEL.contains(value.key())) {
                problems.addAtKey(
                        value,
                        "`"
                                + value.key()
                                + "` does not belong to a level; write it into the item, or into"
                                + " one of the parts of the level");
            }
            boolean isPlace = value.key().equals("physical");
            for (Node inner : isPlace ? value.children() : List.<Node>of()) {
                if (PLACE.contains(inner.key())) {
                    problems.addAtKey(
                            inner,
                            "`"
                                    + inner.key()
                                    + "` does not belong to a level; write it into `physical` of the"
                                    + " item");
                }
            }
        }
    }

    private Optional<LevelCondition> condition(Node node) {
        Optional<String> text = node.text();
        if (text.isEmpty()) {
            return Optional.empty();
        }
        if (scope.isEmpty()) {
            scope = Optional.of(Scope.ofLevels(prototype));
        }
        conditions.add(text.get());
        if (conditions.size() > MAX_CONDITIONS) {
            problems.add(
                    node,
                    "when: more than "
                            + MAX_CONDITIONS
                            + " different conditions of levels; use the same condition for several"
                            + " items");
            return Optional.empty();
        }
        try {
            Expression expression = scope.get().compile(text.get());
            if (!expression.type().suits(ExpressionType.TRUTH)) {
                problems.add(
                        node, "when: is " + expression.type().words() + ", expected true or false");
                return Optional.empty();
            }
            return Optional.of(new LevelRule(expression));
        } catch (ExpressionException refused) {
            problems.addInText(node, refused.offset(), "when: " + refused.getMessage());
            return Optional.empty();
        }
    }

    /**
     * Returns the level that an item begins with: the one that its symbol names, or otherwise the
     * first one. Records a problem and returns empty if there is no such level.
     */
    Optional<Level> active(Node item, List<Level> levels) {
        Optional<Node> wanted = item.get("semantic").flatMap(aspect -> aspect.get(Level.SYMBOL));
        if (wanted.isEmpty() || levels.isEmpty()) {
            return levels.stream().findFirst();
        }
        String name = wanted.get().scalar().map(Object::toString).orElse("");
        Optional<Level> found =
                levels.stream().filter(level -> level.name().equals(name)).findFirst();
        List<String> names =
                item.get(LEVELS).orElseThrow().children().stream().map(Node::key).toList();
        if (found.isEmpty() && !names.contains(name)) {
            problems.add(
                    wanted.get(),
                    "level: the item has no level `"
                            + Node.shorten(name)
                            + "`"
                            + Suggestion.of(name, names));
        }
        return found;
    }

    /**
     * Returns the items of an item with levels at the level that it begins with, relative to the
     * item's place. The first one is the item itself.
     *
     * @param item the item with its levels, without shape and physics
     */
    static List<ItemDefinition> begin(ItemDefinition item, Level active) {
        if (!active.isGroup()) {
            ItemDefinition body = active.items().getFirst();
            ItemDefinition.Builder whole = item.copy(item.name()).physicsOf(body);
            whole.shape(body.shape()).colour(body.colour().toString());
            body.material().ifPresent(whole::material);
            return List.of(whole.build());
        }
        List<ItemDefinition> items = new ArrayList<>();
        String prefix = Level.prefix(item.name());
        ItemDefinition carrier = active.carrier();
        Pose pose = Pose.ORIGIN.relativeTo(Pose.of(carrier.location(), carrier.orientation()));
        items.add(
                item.copy(item.name())
                        .parent(prefix + carrier.name())
                        .at(pose.x(), pose.y(), pose.z())
                        .orientation(pose.qx(), pose.qy(), pose.qz(), pose.qw())
                        .build());
        active.items().forEach(part -> items.add(Level.full(prefix, part).build()));
        return items;
    }
}
