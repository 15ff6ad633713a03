// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;

/** What agents perceive of an item: symbols with text, truth or a number. World's thread only. */
public final class SemanticAspect {

    private final Item item;

    SemanticAspect(Item item) {
        this.item = item;
    }

    /**
     * A symbol of the designer's or of a rule, or a standard one: {@code name}, {@code class},
     * {@code dimensions}, and of bodies {@code location} (three numbers [m]) and {@link Relations}:
     * {@code near}, {@code on}, {@code inside}, {@code touching} (lists of names).
     */
    public Optional<Object> get(String symbol) {
        item.checkedRow();
        if (symbol.equals(StandardSymbols.LOCATION) && !item.physical().isEmpty()) {
            double[] at = item.physical().location();
            return Optional.of(List.of(at[0], at[1], at[2]));
        }
        if (Relations.NAMES.contains(symbol)) {
            return relations().of(item.id(), symbol).map(names -> names);
        }
        return item.symbols().get(symbol);
    }

    /** How bodies of the item's world are to each other, as of the last DERIVE. */
    public Relations relations() {
        item.world().guard.checkOwner();
        return item.world().relations;
    }

    /**
     * Checks a symbol that is to be set later.
     *
     * @param item name of its item, for messages
     * @return the value as {@link #set} keeps it: text, truth, a Double or a list of such
     * @throws IllegalArgumentException as {@link #set}
     */
    public static Object requireSettable(
            WorldPrototype prototype, String item, String symbol, Object value) {
        if (symbol.equals(StandardSymbols.CLASS) && !(value instanceof String)) {
            throw new IllegalArgumentException(
                    "item " + item + ": class is " + value + ", expected a text such as \"toy\"");
        }
        return Values.requireSymbol(prototype, item, symbol, value);
    }

    /**
     * Sets a symbol.
     *
     * @param value String, Boolean, a finite number or a List of such, of the type that the
     *     prototype declares for the symbol, if it does
     * @throws IllegalArgumentException naming item and symbol for any other value, and for the
     *     symbols that the world derives
     */
    public void set(String symbol, Object value) {
        item.checkedRow();
        Object checked = requireSettable(item.world().prototype, item.name(), symbol, value);
        change(symbol, checked, item.symbols().with(symbol, checked));
    }

    /** Forgets a designer's symbol, if there. */
    public void remove(String symbol) {
        item.checkedRow();
        if (item.symbols().given().containsKey(symbol)) {
            change(symbol, null, item.symbols().without(symbol));
        }
    }

    /**
     * Gives the item a symbol that follows from others, in DERIVE; a symbol of that name that the
     * designer or an action gave hides it. Such changes are not noted: whoever has the rest of the
     * world can work them out.
     *
     * @param value as {@link #set}, or null to take the symbol away
     * @throws IllegalArgumentException as {@link #set}
     */
    public void derive(String symbol, @Nullable Object value) {
        item.checkedRow();
        PMap<String, Object> before = item.symbols().derived();
        Object checked =
                value == null
                        ? null
                        : requireSettable(item.world().prototype, item.name(), symbol, value);
        if (!Objects.equals(before.get(symbol), checked)) {
            item.change(
                    item.symbols()
                            .withDerived(
                                    checked == null
                                            ? before.minus(symbol)
                                            : before.plus(symbol, checked)));
        }
    }

    /**
     * All symbols that are kept, standard ones first: see {@link ItemSymbols#symbols()}. Location
     * and relations, which are worked out when asked for, are not among them.
     */
    public Map<String, Object> symbols() {
        item.checkedRow();
        return item.symbols().symbols();
    }

    private void change(String symbol, @Nullable Object to, ItemSymbols changed) {
        Object from = item.symbols().given().get(symbol);
        item.change(changed);
        item.world()
                .note(
                        new WorldChange.Edited(
                                item.id(), WorldChange.Aspect.SEMANTIC, symbol, from, to));
    }
}
