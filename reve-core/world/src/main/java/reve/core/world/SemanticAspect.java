// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.function.Predicate;

/**
 * The semantic aspect of an item: its symbols. A symbol is a named value that agents perceive (a
 * text, a truth value, a number or a list). For the world's thread only.
 */
public final class SemanticAspect {

    private final Item item;

    SemanticAspect(Item item) {
        this.item = item;
    }

    /**
     * Returns a symbol of the designer or of a rule, a symbol that the item inherits from its
     * class, or one of these standard symbols:
     *
     * <ul>
     *   <li>{@code name}, {@code class} and {@code dimensions}
     *   <li>in worlds that declare classes, {@code classes} (a list of names)
     *   <li>for bodies {@code location} (three numbers [m])
     *   <li>for bodies the {@link Relations} {@code near}, {@code on}, {@code inside} and {@code
     *       touching} (lists of names)
     * </ul>
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

    /**
     * Returns whether the item belongs to a class: its own class, or one above it in the world's
     * {@link ClassHierarchy}. Allocates nothing.
     */
    public boolean isA(String itemClass) {
        item.checkedRow();
        return item.symbols().isA(itemClass);
    }

    /**
     * Returns the spatial relations between bodies of the item's world, from the bounding boxes of
     * the last DERIVE phase.
     */
    public Relations relations() {
        item.world().guard.checkOwner();
        return item.world().relations;
    }

    /**
     * Checks a symbol that the caller intends to set later.
     *
     * @param item name of the item, for messages
     * @return the value in the form in which {@link #set} stores it: a text, a truth value, a
     *     Double or a list of these
     * @throws IllegalArgumentException like {@link #set}
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
     * @param value String, Boolean, a finite number or a List of these. If the prototype declares a
     *     type for the symbol, the value must have this type
     * @throws IllegalArgumentException naming item and symbol for any other value, and for symbols
     *     that the world computes itself, and for the symbol of an item's level, which only a
     *     change of the level sets
     */
    public void set(String symbol, Object value) {
        requireNoLevel(symbol);
        restore(symbol, value);
    }

    /**
     * Sets a symbol like {@link #set}. Also sets the symbol of an item's level, for the repetition
     * of recorded changes.
     */
    public void restore(String symbol, Object value) {
        item.checkedRow();
        Object checked = requireSettable(item.world().prototype, item.name(), symbol, value);
        change(symbol, checked, item.symbols().with(symbol, checked));
    }

    /**
     * Removes a symbol that the designer, an action or an edit has set, if present. Symbols of
     * rules stay.
     */
    public void remove(String symbol) {
        item.checkedRow();
        requireNoLevel(symbol);
        if (item.symbols().given().containsKey(symbol)) {
            change(symbol, null, item.symbols().without(symbol));
        }
    }

    /**
     * Sets the symbol of a rule, in the phase DERIVE. A symbol of the same name from the designer
     * or an action takes precedence. The setting is not recorded as a change, because rules can
     * compute the symbol again from the rest of the world.
     *
     * @param value as in {@link #set}, or null to remove the symbol
     * @throws IllegalArgumentException like {@link #set}
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
     * Removes symbols of rules, for example of rules that the world does not have any more. The
     * removal is not recorded as a change, like {@link #derive}.
     *
     * @param isStale whether the symbol of this name is removed
     */
    public void dropDerived(Predicate<String> isStale) {
        item.checkedRow();
        PMap<String, Object> left = item.symbols().derived();
        for (String symbol : item.symbols().derived().keySet()) {
            if (isStale.test(symbol)) {
                left = left.minus(symbol);
            }
        }
        if (left != item.symbols().derived()) {
            item.change(item.symbols().withDerived(left));
        }
    }

    /**
     * Returns all stored symbols, beginning with the standard symbols, see {@link
     * ItemSymbols#symbols()}. Omits location and relations, which are computed when they are read.
     */
    public Map<String, Object> symbols() {
        item.checkedRow();
        return item.symbols().symbols();
    }

    private void requireNoLevel(String symbol) {
        if (item.isLevel(symbol)) {
            throw new IllegalArgumentException(
                    item
                            + ": the symbol level names its active level, which only a change of the"
                            + " level changes");
        }
    }

    private void change(String symbol, @Nullable Object to, ItemSymbols changed) {
        Object from = item.symbols().given().get(symbol);
        item.change(changed);
        item.world()
                .note(
                        new WorldChange.Edited(
                                item.id(), WorldChange.Aspect.SEMANTIC, symbol, from, to));
    }

    /** Returns the number of characters of all texts of a symbol's value. */
    public static long characters(Object value) {
        return switch (value) {
            case String text -> text.length();
            case List<?> list -> list.stream().mapToLong(SemanticAspect::characters).sum();
            default -> 0;
        };
    }
}
