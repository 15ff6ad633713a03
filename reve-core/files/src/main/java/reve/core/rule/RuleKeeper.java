// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.unit.Unit;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.Relations;
import reve.core.world.Shape;
import reve.core.world.SymbolDescriptor;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.function.BooleanSupplier;

/**
 * Updater of the symbol of one rule for all items of its kind. It stores the inputs of the last
 * evaluation for each row. The rule is evaluated for a row again only if these inputs have changed.
 */
final class RuleKeeper {
    /** Result of {@link #update} if no item is left. */
    static final int COMPLETE = -1;

    /**
     * Number of items that an update visits for one step, in addition to the steps of evaluations.
     * This number is for rules that are evaluated only if their inputs have changed. The next
     * number is for all other rules.
     */
    private static final int VISITS_PER_STEP = 8;

    private static final int VISITS_PER_STEP_IF_EVALUATED = 1;

    private static final String CLASS = "class";
    private static final String PHYSICS = "physics.";
    private static final String PHYSICAL = "physical.";

    private final World world;
    private final Rule rule;
    private final Table table;
    private final Computation computation;
    private final Unit unit;

    /**
     * Columns that the rule reads. The field {@link #listed} is false if some input of the rule
     * cannot be compared. Every update then evaluates the rule.
     */
    private final List<Column> columns = new ArrayList<>();

    private final List<String> symbols = new ArrayList<>();
    private final boolean listed;
    private final int numbersPerRow;

    /** Whether the shape of the item is an input. Its entry follows those of the symbols. */
    private boolean readsShape;

    private final int objectsPerRow;
    private long[] ids = {};
    private long[] numbers = {};
    private @Nullable Object[] objects = {};
    private boolean told;
    private long steps;

    /** The item for which the rule is being evaluated. */
    private @Nullable Item current;

    RuleKeeper(World world, Rule rule) {
        this.world = world;
        this.rule = rule;
        this.table = world.table(rule.kind());
        this.computation = computation(world, rule.source());
        this.unit =
                world.prototype()
                        .symbol(rule.symbol())
                        .map(SymbolDescriptor::unit)
                        .orElse(Unit.ONE);
        rule.itemClass().ifPresent(wanted -> symbols.add(CLASS));
        boolean all = rule.source() instanceof SymbolSource.Formula;
        for (String name : rule.source().uses()) {
            all &= list(name);
        }
        listed = all;
        numbersPerRow = columns.stream().mapToInt(Column::components).sum();
        objectsPerRow = symbols.size() + (readsShape ? 1 : 0);
    }

    private static Computation computation(World world, SymbolSource source) {
        return switch (source) {
            case SymbolSource.Formula formula ->
                    new Computation.Formula(formula.expression(), formula.expression().bindings());
            case SymbolSource.Provided provided ->
                    new Computation.Provided(world.guard(), provided.provider());
        };
    }

    /**
     * Adds the column or symbol that a name reads to the inputs. Returns false for other names,
     * such as relations, because their values cannot be compared.
     */
    private boolean list(String name) {
        String symbol = Rule.symbolRead(name);
        if (name.startsWith(PHYSICS)) {
            columns.add(table.column(name.substring(PHYSICS.length())));
        } else if (name.startsWith(PHYSICAL)) {
            switch (name.substring(PHYSICAL.length())) {
                case "location" -> columns.add(table.column("position"));
                case KindNames.MOVABLE -> columns.add(table.column(WorldPrototype.MASS));
                case KindNames.VOLUME -> readsShape = true;
                case KindNames.SUBSTANCE -> {
                    if (world.prototype().hasSubstances()) {
                        columns.add(table.column(WorldPrototype.SUBSTANCE));
                    }
                }
                case String property -> columns.add(table.column(property));
            }
        } else if (name.equals("item.name")) {
            symbols.add("name");
        } else if (symbol != null && !Relations.NAMES.contains(symbol)) {
            if (symbol.equals("location") && rule.kind().equals(WorldPrototype.BODY)) {
                columns.add(table.column("position"));
            } else {
                symbols.add(symbol);
            }
        } else {
            return name.equals("item.kind");
        }
        return true;
    }

    Rule rule() {
        return rule;
    }

    /** Removes the symbol of the rule from all items. */
    void takeBack() {
        for (int row = 0; row < table.rowCount(); row++) {
            itemAt(row).semantic().derive(rule.symbol(), null);
        }
    }

    /**
     * Makes all items count as changed. The method stores the id 0 for each row, because no item
     * has this id.
     */
    void forget() {
        Arrays.fill(ids, 0);
    }

    /**
     * Evaluates the rule for the items whose inputs have changed, beginning at a row. Ends early if
     * the evaluations take too many steps, or if {@code ends} returns true.
     *
     * @param most maximum number of steps; the evaluation that exceeds it is completed and is the
     *     last one
     * @param ends returns true to end early for another reason
     * @return the row at which the next call must continue, or {@link #COMPLETE}
     */
    int update(long frame, int fromRow, long most, BooleanSupplier ends) {
        steps = 0;
        world.activity().begin(this);
        try {
            return updateRows(frame, fromRow, most, ends);
        } finally {
            world.activity().end();
        }
    }

    /** Returns the number of steps that the last update took. */
    long steps() {
        return steps;
    }

    /**
     * Raises a fault event. It reports that the rules take too many steps, and that this rule takes
     * the most.
     *
     * @param why text after the rule's name in the message of the fault
     */
    void reportTooManySteps(long frame, String why) {
        raise(frame, "TooManySteps", "rule " + rule.symbol() + " " + why);
    }

    /**
     * Returns a description of the rule and of the item for which it is being evaluated. For any
     * thread.
     */
    @Override
    public String toString() {
        Item item = current;
        return "rule "
                + rule.symbol()
                + (item == null ? "" : " of " + item.name())
                + ": `"
                + rule.source()
                + "`";
    }

    private int updateRows(long frame, int fromRow, long most, BooleanSupplier ends) {
        int rows = rule.needsPhysics() ? table.physicsRowCount() : table.rowCount();
        int visitsPerStep = listed ? VISITS_PER_STEP : VISITS_PER_STEP_IF_EVALUATED;
        makeRoom(table.rowCount());
        for (int row = fromRow; row < table.rowCount(); row++) {
            if (steps > most || ends.getAsBoolean()) {
                return row;
            }
            if (row % visitsPerStep == 0) {
                steps++;
            }
            Item item = itemAt(row);
            if (row >= rows) {
                takeBackFromScenery(row, item);
                continue;
            }
            boolean changed = hasChanged(row, item);
            if (!changed && listed) {
                continue;
            }
            boolean applies = applies(item);
            if (applies || changed) {
                give(item, applies ? evaluate(item, frame) : null, frame);
            }
        }
        return COMPLETE;
    }

    /** Removes the symbol from scenery, which may have had a physics aspect before. */
    private void takeBackFromScenery(int row, Item item) {
        long mark = -item.id().value(); // no item with a physics aspect has a negative id
        if (ids[row] != mark) {
            ids[row] = mark;
            item.semantic().derive(rule.symbol(), null);
        }
    }

    private Item itemAt(int row) {
        return world.item(table.idAt(row));
    }

    private void makeRoom(int rows) {
        if (ids.length < rows) {
            int room = Math.max(rows, 2 * ids.length);
            ids = Arrays.copyOf(ids, room);
            numbers = Arrays.copyOf(numbers, room * numbersPerRow);
            objects = Arrays.copyOf(objects, room * objectsPerRow);
        }
    }

    /**
     * Returns whether the rule's inputs for an item differ from those stored for the row. Stores
     * the new inputs.
     */
    private boolean hasChanged(int row, Item item) {
        boolean changed = ids[row] != item.id().value();
        ids[row] = item.id().value();
        int at = row * numbersPerRow;
        for (int i = 0; i < columns.size(); i++) {
            Column column = columns.get(i);
            for (int component = 0; component < column.components(); component++, at++) {
                long bits = Double.doubleToRawLongBits(column.getDouble(row, component));
                changed |= numbers[at] != bits;
                numbers[at] = bits;
            }
        }
        at = row * objectsPerRow;
        for (int i = 0; i < symbols.size(); i++, at++) {
            Object value = item.semantic().get(symbols.get(i)).orElse(null);
            changed |= !Objects.equals(objects[at], value);
            objects[at] = value;
        }
        if (readsShape) {
            Shape shape = item.physical().shape();
            changed |= !shape.equals(objects[at]);
            objects[at] = shape;
        }
        return changed;
    }

    private boolean applies(Item item) {
        return rule.itemClass().isEmpty() || item.semantic().isA(rule.itemClass().get());
    }

    private @Nullable Object evaluate(Item item, long frame) {
        current = item;
        long taken = 1;
        long before = computation.steps();
        try {
            Object value = computation.compute(item);
            return value instanceof Double number ? number / unit.scale() : value;
        } catch (EvaluationException failed) {
            taken += Meter.STEPS_OF_FAILURE;
            tell(item, frame, failed);
            return null;
        } finally {
            taken += computation.steps() - before;
            steps += taken;
            world.charges().charge(item.id(), taken);
        }
    }

    private void give(Item item, @Nullable Object value, long frame) {
        try {
            item.semantic().derive(rule.symbol(), value);
        } catch (IllegalArgumentException refused) {
            item.semantic().derive(rule.symbol(), null);
            tell(item, frame, refused);
        }
    }

    private void tell(Item item, long frame, Exception failed) {
        if (told) {
            return;
        }
        told = true;
        if (rule.source() instanceof SymbolSource.Provided provided) {
            Throwable cause = failed.getCause() == null ? failed : failed.getCause();
            world.providerFaults()
                    .report(
                            frame,
                            "DERIVE",
                            "rule " + rule.symbol(),
                            provided.provider(),
                            cause,
                            item.name() + " has no " + rule.symbol() + " (reported once)");
            return;
        }
        raise(
                frame,
                failed.getClass().getSimpleName(),
                item
                        + " gets no "
                        + rule.symbol()
                        + ": "
                        + failed.getMessage()
                        + " (reported once; other items may have the same problem)");
    }

    private void raise(long frame, String error, String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("phase", "DERIVE");
        fields.put("source", "rule " + rule.symbol());
        fields.put("error", error);
        fields.put("message", message);
        world.raise(new WorldEvent(frame, "fault", fields));
    }
}
