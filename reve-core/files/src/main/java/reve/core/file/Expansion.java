// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.mesh.WorldFolder;
import reve.core.world.ItemDefinition;
import reve.core.world.SemanticAspect;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Expansion of items. It adds the values of their prefabs (templates) to items, and creates the
 * repetitions of items.
 */
final class Expansion {
    /** Maximum number of values of all items after expansion. */
    static final int MAX_VALUES = 10_000_000;

    /** Maximum number of items, including repetitions. */
    static final int MAX_ITEMS = 1_000_000;

    /**
     * Maximum number of parts of groups, including repetitions. A part takes more memory than the
     * repetition of an item.
     */
    static final int MAX_PARTS = 200_000;

    /** Maximum number of formula evaluations for all repetitions. */
    static final int MAX_FORMULAS = 10_000_000;

    /** Maximum number of items, including repetitions, of one message. */
    static final int MAX_ITEMS_OF_MESSAGE = 10_000;

    /**
     * Maximum number of characters in the symbols of all items of one message. Items share the
     * texts of their prefab, but each perception contains the texts of each item.
     */
    static final long MAX_CHARACTERS_OF_MESSAGE = 4_000_000;

    /**
     * Divisor of the limits of a world file. A message may create a tenth of the values and
     * formulas of a world file.
     */
    private static final int PART_OF_MESSAGE = 10;

    /** Keys of items whose formulas have indices of their own. */
    private static final List<String> NESTED = List.of(GroupReader.PARTS, LevelReader.LEVELS);

    private final Problems problems;
    private final SourceFiles files;
    private final Room values;
    private final Prefabs prefabs;
    private final long firstNumber;

    /** Numbers of parts, by the names of the prefabs. */
    private final Map<String, Long> partsOfPrefabs = new HashMap<>();

    /**
     * @param source the file with the prefabs
     * @param limits numbers of items, values and formulas that may still be created; this expansion
     *     reduces them
     */
    Expansion(WorldSource source, Limits limits, Problems problems) throws WorldFileException {
        this.problems = problems;
        this.files = source.files();
        this.firstNumber = source.firstNumber();
        this.values = new Room(limits, problems);
        this.prefabs = new Prefabs(source.named("prefabs"), problems, values);
    }

    /** Returns an expansion of a part of a file that uses no prefabs. */
    static Expansion withoutPrefabs(Node part, Problems problems) throws WorldFileException {
        var files = new SourceFiles(WorldFolder.none(), problems.file());
        return new Expansion(new WorldSource(part, List.of(), files), Limits.ofWorld(), problems);
    }

    /** A receiver of expanded items. */
    interface Sink {
        void accept(Node item) throws WorldFileException;

        /** Receives one repetition of an item. */
        void accept(Template item, Repetition repetition) throws WorldFileException;
    }

    /** The numbers of items, values and formulas that a world file, or a message, may create. */
    static final class Limits {
        private final long items;
        private final long values;
        private final long formulas;
        private final String where;
        private final Allowance itemsLeft;
        private final Allowance partsLeft = new Allowance(MAX_PARTS);
        private final Allowance valuesLeft;
        private final Allowance formulasLeft;
        private final Allowance charactersLeft;

        private Limits(long items, long values, long formulas, long characters, String where) {
            this.items = items;
            this.values = values;
            this.formulas = formulas;
            this.where = where;
            itemsLeft = new Allowance(items);
            valuesLeft = new Allowance(values);
            formulasLeft = new Allowance(formulas);
            charactersLeft = new Allowance(characters);
        }

        /** Returns the limits of a world file with all files that it includes. */
        static Limits ofWorld() {
            return new Limits(MAX_ITEMS, MAX_VALUES, MAX_FORMULAS, Long.MAX_VALUE, "");
        }

        /** Returns the limits of one message, which may contain several changes. */
        static Limits ofMessage() {
            return new Limits(
                    MAX_ITEMS_OF_MESSAGE,
                    MAX_VALUES / PART_OF_MESSAGE,
                    MAX_FORMULAS / PART_OF_MESSAGE,
                    MAX_CHARACTERS_OF_MESSAGE,
                    " in one message");
        }

        /**
         * Reserves room for the characters in the symbols of items.
         *
         * @throws WorldFileException at the item for which there is no room
         */
        void requireCharacters(List<ItemDefinition> items, Problems problems)
                throws WorldFileException {
            for (ItemDefinition item : items) {
                long characters = 0;
                for (Object value : item.symbols().values()) {
                    characters += SemanticAspect.characters(value);
                }
                if (!charactersLeft.take(characters)) {
                    throw problems.fatal(
                            1,
                            1,
                            "the symbols of all items with their repetitions have more than "
                                    + MAX_CHARACTERS_OF_MESSAGE
                                    + " characters"
                                    + where
                                    + "; the item "
                                    + item.name()
                                    + " exceeds the limit");
                }
            }
        }
    }

    /**
     * The remaining amounts of one set of limits, from which items, values and formulas are
     * subtracted.
     */
    static final class Room {
        private final Problems problems;
        private final Limits limits;

        private Room(Limits limits, Problems problems) {
            this.limits = limits;
            this.problems = problems;
        }

        /**
         * Reserves room for items.
         *
         * @throws WorldFileException at the item if there is no room for it and its repetitions
         */
        void requireItems(long count, Node item) throws WorldFileException {
            if (!limits.itemsLeft.take(count)) {
                throw problems.of(item.file())
                        .fatal(
                                item.line(),
                                item.column(),
                                "more than "
                                        + limits.items
                                        + " items with their repetitions"
                                        + limits.where);
            }
        }

        /**
         * Reserves room for the parts of groups, which are items.
         *
         * @throws WorldFileException at the item if there is no room for its parts
         */
        void requireParts(long count, Node item) throws WorldFileException {
            requireItems(count, item);
            if (!limits.partsLeft.take(count)) {
                throw problems.of(item.file())
                        .fatal(
                                item.line(),
                                item.column(),
                                "more than "
                                        + MAX_PARTS
                                        + " parts of groups with their repetitions"
                                        + limits.where);
            }
        }

        /**
         * Reserves formula evaluations.
         *
         * @throws WorldFileException at the item if its repetitions evaluate too many formulas
         */
        void requireFormulas(long count, Node item) throws WorldFileException {
            if (!limits.formulasLeft.take(count)) {
                throw problems.of(item.file())
                        .fatal(
                                item.line(),
                                item.column(),
                                "more than "
                                        + limits.formulas
                                        + " formulas in all items with their repetitions"
                                        + limits.where
                                        + "; a text "
                                        + "counts as one more for each 64 characters");
            }
        }

        /**
         * Reserves room for values.
         *
         * @throws WorldFileException at the item if there is no room for its values
         */
        void require(long count, Node item) throws WorldFileException {
            if (!limits.valuesLeft.take(count)) {
                throw problems.of(item.file())
                        .fatal(
                                item.line(),
                                item.column(),
                                "more than "
                                        + limits.values
                                        + " values in all items with what they are like and their "
                                        + "repetitions"
                                        + limits.where);
            }
        }
    }

    /** Returns an item or agent body completed with the values of its prefab. */
    Node complete(Node item) throws WorldFileException {
        return prefabs.complete(item);
    }

    /** Returns the prefabs that no item uses. */
    List<Node> unusedPrefabs() {
        return prefabs.unused();
    }

    /**
     * Refuses too many items before any item is created. Counts the parts of groups, too. The
     * repetitions by a table are counted when the table is read.
     */
    void requireRoom(List<Node> items) throws WorldFileException {
        for (Node item : items) {
            Optional<Node> repeat = item.get("repeat");
            if (!isTable(repeat)) {
                long count = repeat.map(Expansion::count).orElse(1L);
                values.requireItems(count, item);
                requireParts(count, item);
            }
        }
    }

    private void requireParts(long groups, Node group) throws WorldFileException {
        long parts = partsOf(group, 1);
        values.requireParts(parts == 0 ? 0 : Math.min(groups, MAX_PARTS + 1L) * parts, group);
    }

    private static boolean isTable(Optional<Node> repeat) {
        return repeat.flatMap(Node::text).isPresent();
    }

    /**
     * Returns the number of parts of one item, which is 0 if the item has none. Stops counting
     * above {@link #MAX_PARTS}. The count lacks parts that are repeated by a table, and groups that
     * are nested too deeply.
     */
    private long partsOf(Node item, int depth) {
        if (depth > GroupReader.MAX_DEPTH) {
            return 0;
        }
        Optional<String> like = item.get("like").flatMap(Node::text);
        if (like.isPresent() && NESTED.stream().noneMatch(key -> item.get(key).isPresent())) {
            Long known = partsOfPrefabs.get(like.get());
            if (known == null) {
                partsOfPrefabs.put(like.get(), 0L); // while it is counted: a prefab in itself
                known = prefabs.find(like.get()).map(node -> sum(node, depth)).orElse(0L);
                partsOfPrefabs.put(like.get(), known);
            }
            return known;
        }
        Node whole =
                like.flatMap(prefabs::find).filter(Node::isMapping).map(item::over).orElse(item);
        return sum(whole, depth);
    }

    /** Returns the number of parts of a completed group, or of all levels of a completed item. */
    private long sum(Node group, int depth) {
        long sum = 0;
        for (Node level : group.get(LevelReader.LEVELS).map(Node::children).orElse(List.of())) {
            sum = Math.min(sum + partsOf(level, depth + 1), MAX_PARTS + 1L);
        }
        for (Node part : group.get(GroupReader.PARTS).map(Node::children).orElse(List.of())) {
            Optional<Node> repeat =
                    part.get("repeat")
                            .or(
                                    () ->
                                            part.get("like")
                                                    .flatMap(Node::text)
                                                    .flatMap(prefabs::find)
                                                    .flatMap(node -> node.get("repeat")));
            long count = isTable(repeat) ? 0 : repeat.map(Expansion::count).orElse(1L);
            sum += Math.min(count, MAX_PARTS + 1L) * (1 + partsOf(part, depth + 1));
            if (sum > MAX_PARTS) {
                return MAX_PARTS + 1L;
            }
        }
        return sum;
    }

    private static long count(Node repeat) {
        double count = 1;
        for (Node each : repeat.isMapping() ? repeat.children() : List.of(repeat)) {
            count *= each.number().orElse(1.0);
        }
        return (long) Math.max(0, count);
    }

    /** Reserves room for the values of an item that is a part of a group. */
    void requireValues(Node part) throws WorldFileException {
        values.require(1 + part.fieldCount(), part);
    }

    /**
     * Passes the item, or all of its repetitions, to the sink. The formulas of a group are
     * evaluated without those of its parts, which have indices of their own. The same holds for an
     * item with levels.
     */
    void expand(Node item, Sink sink) throws WorldFileException {
        if (problems.full()) {
            return;
        }
        Node complete = complete(item);
        Optional<Node> repeat = complete.get("repeat");
        if (repeat.isEmpty()) {
            sink.accept(complete);
            return;
        }
        Optional<Repetition> repetition = Repetition.read(repeat.get(), files, problems);
        if (repetition.isPresent()) {
            repeat(
                    complete.without("repeat"),
                    repetition.get(),
                    repeat.get().text().isPresent(),
                    sink);
        }
    }

    private void repeat(Node whole, Repetition repetition, boolean fromTable, Sink sink)
            throws WorldFileException {
        Map<String, Node> nested = new LinkedHashMap<>();
        for (String key : NESTED) {
            whole.get(key).ifPresent(value -> nested.put(key, value));
        }
        Node item = whole.without(GroupReader.PARTS).without(LevelReader.LEVELS);
        if (fromTable) {
            values.requireItems(repetition.count(), item);
            requireParts(repetition.count(), whole);
        }
        var template = new Template(item, repetition.variables(), problems, firstNumber);
        values.require(Math.min(repetition.count(), MAX_VALUES) * (1 + template.size()), item);
        values.requireFormulas(
                Math.min(repetition.count(), MAX_FORMULAS + 1L) * template.formulas(), item);
        Optional<Node> fixed =
                item.get("name")
                        .filter(
                                node ->
                                        node.text()
                                                .filter(name -> name.indexOf('{') < 0)
                                                .isPresent());
        if (fixed.isPresent() && repetition.count() > 1) {
            problems.add(
                    fixed.get(),
                    "name: the item is repeated, so its name needs a formula, "
                            + "as in `ball-{"
                            + repetition.variables().getFirst()
                            + "}`");
            return;
        }
        if (nested.isEmpty()) {
            sink.accept(template, repetition);
            return;
        }
        Node parts = whole.withValue(nested);
        for (long n = 0; n < repetition.count() && !problems.full(); n++) {
            sink.accept(template.make(repetition.values().at(n), n).over(parts));
        }
    }
}
