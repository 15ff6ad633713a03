// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.ItemId;

import java.util.List;

/**
 * The perception of a client in one frame: the perceived items in the order of their ids, and the
 * readings of instruments. Immutable.
 *
 * @param time simulated time of the world [s]
 * @param readings the newest reading of each instrument of the client's body
 */
public record View(long frame, double time, List<PerceivedItem> items, List<Reading> readings) {

    /** Creates a view without readings. */
    public View(long frame, double time, List<PerceivedItem> items) {
        this(frame, time, items, List.of());
    }

    /** Returns the index of an item in the list; negative if the view does not contain the item. */
    int indexOf(ItemId id) {
        int low = 0;
        int high = items.size() - 1;
        while (low <= high) {
            int middle = (low + high) >>> 1;
            int order = items.get(middle).id().compareTo(id);
            if (order == 0) {
                return middle;
            }
            if (order < 0) {
                low = middle + 1;
            } else {
                high = middle - 1;
            }
        }
        return -1;
    }

    boolean holds(String name) {
        return items.stream().anyMatch(seen -> seen.name().equals(name));
    }
}
