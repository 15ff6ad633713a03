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

    /** Number of characters that are searched between two looks at the clock, at least. */
    private static final int STEP = 65_536;

    /** Symbols that the search omits: the name, which it compares first, and lists of extents. */
    private static final Set<String> OMITTED = Set.of("name", "dimensions");

    private final Iterator<ItemSymbols> rest;
    private final char[] wanted;

    /**
     * For each length of a beginning of the wanted text: the length of the longest shorter
     * beginning with which it ends, as in the algorithm of Knuth, Morris and Pratt. The time of a
     * search is therefore proportional to the length of the searched text.
     */
    private final int[] borders;

    private final List<Object> items = new ArrayList<>();
    private int count;
    private long searched;

    ItemSearch(Collection<ItemSymbols> all, String text) {
        rest = all.iterator();
        wanted = new char[text.length()];
        for (int i = 0; i < wanted.length; i++) {
            wanted[i] = folded(text.charAt(i));
        }
        borders = new int[wanted.length + 1];
        for (int end = 1, length = 0; end < wanted.length; end++) {
            length = extended(length, wanted[end]);
            borders[end + 1] = length;
        }
    }

    private static char folded(char letter) {
        return Character.toLowerCase(Character.toUpperCase(letter));
    }

    /** Returns the length of the longest beginning with which a text ends after one more letter. */
    private int extended(int length, char next) {
        int longest = length;
        while (longest > 0 && wanted[longest] != next) {
            longest = borders[longest];
        }
        return wanted[longest] == next ? longest + 1 : longest;
    }

    /** Searches some more items. Returns false if there are no more. */
    boolean step() {
        long pause = searched + STEP;
        while (searched < pause && rest.hasNext()) {
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
        searched += text.length() + 1;
        int length = 0;
        for (int i = 0; i < text.length() && length < wanted.length; i++) {
            length = extended(length, folded(text.charAt(i)));
        }
        return length == wanted.length;
    }
}
