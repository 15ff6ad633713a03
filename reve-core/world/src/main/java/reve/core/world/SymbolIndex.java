// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Collection;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.TreeSet;

/**
 * An index that finds the items with a given value of a symbol. It contains only the symbols that
 * were searched for, so other symbols cost nothing. For the world's thread only.
 */
final class SymbolIndex {

    private final Map<String, Map<Object, TreeSet<ItemId>>> byValue = new HashMap<>();

    /**
     * Returns a copy of the ids of the items with that value, in ascending order.
     *
     * @param all the symbolic data of every item, from which the first search builds the index
     */
    List<ItemId> find(String symbol, Object value, Collection<ItemSymbols> all) {
        Map<Object, TreeSet<ItemId>> index = byValue.get(symbol);
        if (index == null) {
            index = new HashMap<>();
            byValue.put(symbol, index);
            for (ItemSymbols item : all) {
                add(index, symbol, item);
            }
        }
        TreeSet<ItemId> found = index.get(key(value));
        return found == null ? List.of() : List.copyOf(found);
    }

    /** Discards all indexes, after all items were replaced. */
    void clear() {
        byValue.clear();
    }

    void add(ItemSymbols item) {
        byValue.forEach((symbol, index) -> add(index, symbol, item));
    }

    void remove(ItemSymbols item) {
        byValue.forEach((symbol, index) -> remove(index, symbol, item));
    }

    private static void add(Map<Object, TreeSet<ItemId>> index, String symbol, ItemSymbols item) {
        for (Object value : values(symbol, item)) {
            index.computeIfAbsent(key(value), none -> new TreeSet<>()).add(item.id());
        }
    }

    private static void remove(
            Map<Object, TreeSet<ItemId>> index, String symbol, ItemSymbols item) {
        for (Object value : values(symbol, item)) {
            index.computeIfPresent(
                    key(value),
                    (same, items) -> {
                        items.remove(item.id());
                        return items.isEmpty() ? null : items;
                    });
        }
    }

    /** Returns the value of a symbol. Returns each class of the item if the symbol lists them. */
    private static Collection<?> values(String symbol, ItemSymbols item) {
        Object value = item.get(symbol).orElse(null);
        return value == null
                ? List.of()
                : symbol.equals(StandardSymbols.CLASSES) && value instanceof List<?> classes
                        ? classes
                        : List.of(value);
    }

    /** Returns a key for the index. Equal numbers of any type have equal keys, also 0 and -0. */
    private static Object key(Object value) {
        return value instanceof Number number ? Double.valueOf(number.doubleValue() + 0.0) : value;
    }
}
