// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.Comparator;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.TreeSet;
import java.util.function.Supplier;

/**
 * Which items have which value of a symbol. A symbol is indexed from the first time it is asked
 * for, so that others cost nothing. World's thread only.
 */
final class SymbolIndex {

    private final Map<String, Map<Object, TreeSet<Item>>> byValue = new HashMap<>();

    /**
     * Items that have the value, in the order of their ids; a copy.
     *
     * @param all gives every item of the world, to look through for a symbol not yet indexed
     */
    List<Item> find(String symbol, Object value, Supplier<List<Item>> all) {
        Map<Object, TreeSet<Item>> index = byValue.get(symbol);
        if (index == null) {
            index = new HashMap<>();
            byValue.put(symbol, index);
            for (Item item : all.get()) {
                add(index, symbol, item, item.symbols());
            }
        }
        TreeSet<Item> found = index.get(key(value));
        return found == null ? List.of() : List.copyOf(found);
    }

    /** Forgets everything, after items were replaced as a whole. */
    void clear() {
        byValue.clear();
    }

    /**
     * Follows a change of an item.
     *
     * @param from null if the item is new
     * @param to null if it is gone
     */
    void follow(Item item, @Nullable ItemSymbols from, @Nullable ItemSymbols to) {
        byValue.forEach(
                (symbol, index) -> {
                    if (from != null) {
                        remove(index, symbol, item, from);
                    }
                    if (to != null) {
                        add(index, symbol, item, to);
                    }
                });
    }

    private static void add(
            Map<Object, TreeSet<Item>> index, String symbol, Item item, ItemSymbols symbols) {
        symbols.get(symbol)
                .ifPresent(
                        value ->
                                index.computeIfAbsent(
                                                key(value),
                                                none ->
                                                        new TreeSet<>(
                                                                Comparator.comparing(Item::id)))
                                        .add(item));
    }

    private static void remove(
            Map<Object, TreeSet<Item>> index, String symbol, Item item, ItemSymbols symbols) {
        symbols.get(symbol)
                .ifPresent(
                        value ->
                                index.computeIfPresent(
                                        key(value),
                                        (same, items) -> {
                                            items.remove(item);
                                            return items.isEmpty() ? null : items;
                                        }));
    }

    /** Numbers are equal whatever their type and the sign of their zero. */
    private static Object key(Object value) {
        return value instanceof Number number ? Double.valueOf(number.doubleValue() + 0.0) : value;
    }
}
