// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.List;
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

    /** Maximum number of formula evaluations for all repetitions. */
    static final int MAX_FORMULAS = 10_000_000;

    /** Maximum number of items, including repetitions, of one message. */
    static final int MAX_ITEMS_OF_MESSAGE = 10_000;

    /**
     * Divisor of the limits of a world file. A message may create a tenth of the values and
     * formulas of a world file.
     */
    private static final int PART_OF_MESSAGE = 10;

    private final Problems problems;
    private final SourceFiles files;
    private final Room values;
    private final Prefabs prefabs;
    private final long firstNumber;

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
        private final Allowance valuesLeft;
        private final Allowance formulasLeft;

        private Limits(long items, long values, long formulas, String where) {
            this.items = items;
            this.values = values;
            this.formulas = formulas;
            this.where = where;
            itemsLeft = new Allowance(items);
            valuesLeft = new Allowance(values);
            formulasLeft = new Allowance(formulas);
        }

        /** Returns the limits of a world file with all files that it includes. */
        static Limits ofWorld() {
            return new Limits(MAX_ITEMS, MAX_VALUES, MAX_FORMULAS, "");
        }

        /** Returns the limits of one message, which may contain several changes. */
        static Limits ofMessage() {
            return new Limits(
                    MAX_ITEMS_OF_MESSAGE,
                    MAX_VALUES / PART_OF_MESSAGE,
                    MAX_FORMULAS / PART_OF_MESSAGE,
                    " in one message");
        }
    }

    /** The numbers of items, values and formulas that may still be created. */
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
     * Refuses too many items before any item is created. The repetitions by a table are counted
     * when the table is read.
     */
    void requireRoom(List<Node> items) throws WorldFileException {
        for (Node item : items) {
            Optional<Node> repeat = item.get("repeat");
            if (repeat.filter(node -> node.text().isPresent()).isEmpty()) {
                values.requireItems(repeat.map(Expansion::count).orElse(1L), item);
            }
        }
    }

    private static long count(Node repeat) {
        double count = 1;
        for (Node each : repeat.isMapping() ? repeat.children() : List.of(repeat)) {
            count *= each.number().orElse(1.0);
        }
        return (long) Math.max(0, count);
    }

    /** Passes the item, or all of its repetitions, to the sink. */
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

    private void repeat(Node item, Repetition repetition, boolean fromTable, Sink sink)
            throws WorldFileException {
        if (fromTable) {
            values.requireItems(repetition.count(), item);
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
        sink.accept(template, repetition);
    }
}
