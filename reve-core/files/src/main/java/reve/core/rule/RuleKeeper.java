// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import org.jspecify.annotations.Nullable;

import reve.core.unit.Unit;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.Relations;
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
 * evaluation for each row. While the inputs of a row do not change, the rule is not evaluated for
 * it again.
 */
final class RuleKeeper {
    /** Result of {@link #update} if no item is left. */
    static final int COMPLETE = -1;

    /**
     * Number of items that an update visits for one step, in addition to the evaluations. The first
     * number is for rules that are evaluated only if their inputs have changed.
     */
    private static final int VISITS_PER_STEP = 8;

    private static final int VISITS_PER_STEP_IF_EVALUATED = 1;

    private static final String CLASS = "class";
    private static final String PHYSICS = "physics.";
    private static final String PHYSICAL = "physical.";

    private final World world;
    private final Rule rule;
    private final Table table;
    private final Bindings bindings;
    private final Unit unit;

    /**
     * Columns that the rule reads. If some input cannot be compared ({@link #listed} is false),
     * every update evaluates the rule.
     */
    private final List<Column> columns = new ArrayList<>();

    private final List<String> symbols = new ArrayList<>();
    private final boolean listed;
    private final int numbersPerRow;
    private long[] ids = {};
    private long[] numbers = {};
    private @Nullable Object[] texts = {};
    private boolean told;
    private long steps;

    /** The item for which the rule is being evaluated. */
    private @Nullable Item current;

    RuleKeeper(World world, Rule rule) {
        this.world = world;
        this.rule = rule;
        this.table = world.table(rule.kind());
        this.bindings = rule.expression().bindings();
        this.unit =
                world.prototype()
                        .symbol(rule.symbol())
                        .map(SymbolDescriptor::unit)
                        .orElse(Unit.ONE);
        rule.itemClass().ifPresent(wanted -> symbols.add(CLASS));
        boolean all = true;
        for (String name : rule.expression().uses()) {
            all &= list(name);
        }
        listed = all;
        numbersPerRow = columns.stream().mapToInt(Column::components).sum();
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
            String property = name.substring(PHYSICAL.length());
            columns.add(table.column(property.equals("location") ? "position" : property));
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

    /** Makes all items count as changed. For this purpose it stores the id 0, which no item has. */
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
                + rule.expression()
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
            texts = Arrays.copyOf(texts, room * symbols.size());
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
        at = row * symbols.size();
        for (int i = 0; i < symbols.size(); i++, at++) {
            Object value = item.semantic().get(symbols.get(i)).orElse(null);
            changed |= !Objects.equals(texts[at], value);
            texts[at] = value;
        }
        return changed;
    }

    private boolean applies(Item item) {
        return rule.itemClass().isEmpty() || rule.itemClass().equals(item.semantic().get(CLASS));
    }

    private @Nullable Object evaluate(Item item, long frame) {
        current = item;
        long taken = 1;
        long before = bindings.steps();
        try {
            Object value = rule.expression().evaluate(bindings.of(item));
            return value instanceof Double number ? number / unit.scale() : value;
        } catch (EvaluationException failed) {
            taken += Meter.STEPS_OF_FAILURE;
            tell(item, frame, failed);
            return null;
        } finally {
            taken += bindings.steps() - before;
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
