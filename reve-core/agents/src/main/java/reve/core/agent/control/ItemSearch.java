// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.world.ItemSymbols;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Iterator;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * A search of items by a text in their names, or in the names or values of their symbols. The case
 * of letters does not matter. Numbers in lists, such as extents, are not searched. Not thread-safe.
 */
final class ItemSearch {

    /** Maximum number of items in a report. */
    static final int MOST = 100;

    /** Number of items between two looks at the clock. */
    private static final int STEP = 64;

    /** Symbols that the search omits: the name, which it compares first, and lists of extents. */
    private static final Set<String> OMITTED = Set.of("name", "dimensions");

    private final Iterator<ItemSymbols> rest;
    private final String wanted;
    private final List<Object> items = new ArrayList<>();
    private int count;

    ItemSearch(Collection<ItemSymbols> all, String text) {
        rest = all.iterator();
        wanted = text;
    }

    /** Searches some more items. Returns false if there are no more. */
    boolean step() {
        for (int i = 0; i < STEP && rest.hasNext(); i++) {
            ItemSymbols item = rest.next();
            Map<String, Object> symbols = matching(item);
            if (!symbols.isEmpty() || contains(item.name())) {
                count++;
                if (items.size() < MOST) {
                    var found = new LinkedHashMap<String, Object>();
                    found.put("name", item.name());
                    found.put("symbols", symbols);
                    items.add(found);
                }
            }
        }
        return rest.hasNext();
    }

    /** Returns the number of items that contain the text, and the first of them with the reason. */
    Map<String, Object> result() {
        var content = new LinkedHashMap<String, Object>();
        content.put("count", count);
        content.put("items", items);
        return content;
    }

    /** Returns the symbols whose name or value contains the text, except the item's name. */
    private Map<String, Object> matching(ItemSymbols item) {
        Map<String, Object> found = Map.of();
        for (Map.Entry<String, Object> symbol : item.symbols().entrySet()) {
            if (!OMITTED.contains(symbol.getKey())
                    && (contains(symbol.getKey()) || holds(symbol.getValue()))) {
                if (found.isEmpty()) {
                    found = new LinkedHashMap<>();
                }
                found.put(symbol.getKey(), symbol.getValue());
            }
        }
        return found;
    }

    private boolean holds(Object value) {
        return switch (value) {
            case String text -> contains(text);
            case List<?> list ->
                    list.stream().anyMatch(each -> each instanceof String && holds(each));
            default -> contains(String.valueOf(value));
        };
    }

    private boolean contains(String text) {
        int last = text.length() - wanted.length();
        for (int i = 0; i <= last; i++) {
            if (text.regionMatches(true, i, wanted, 0, wanted.length())) {
                return true;
            }
        }
        return false;
    }
}
