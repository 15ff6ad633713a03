// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Arrays;

/**
 * A hash table from item ids to numbers, with linear probing and without an object per entry. For
 * the world's thread only.
 */
final class IdMap {

    private static final int INITIAL_SLOTS = 64;

    /** Ids of items, 0 in empty slots. */
    private long[] keys = new long[INITIAL_SLOTS];

    private int[] values = new int[INITIAL_SLOTS];
    private int size;

    /** Returns the number of an item, or {@code missing} if it has none. */
    int get(long id, int missing) {
        int slot = slotOf(id);
        return keys[slot] == id ? values[slot] : missing;
    }

    void put(long id, int value) {
        int slot = slotOf(id);
        if (keys[slot] == 0) {
            if (5L * (size + 1) > 4L * keys.length) {
                grow();
                slot = slotOf(id);
            }
            keys[slot] = id;
            size++;
        }
        values[slot] = value;
    }

    void remove(long id) {
        int gap = slotOf(id);
        if (keys[gap] == 0) {
            return;
        }
        keys[gap] = 0;
        size--;
        // A later entry may be in its slot only because the slot of the removed entry was occupied.
        // Such an entry moves into the gap, because searches would not find it otherwise.
        for (int i = after(gap); keys[i] != 0; i = after(i)) {
            long moved = keys[i];
            keys[i] = 0;
            int slot = slotOf(moved);
            keys[slot] = moved;
            values[slot] = values[i];
        }
    }

    void clear() {
        Arrays.fill(keys, 0);
        size = 0;
    }

    private void grow() {
        long[] oldKeys = keys;
        int[] oldValues = values;
        keys = new long[Math.multiplyExact(oldKeys.length, 2)];
        values = new int[keys.length];
        for (int i = 0; i < oldKeys.length; i++) {
            if (oldKeys[i] != 0) {
                int slot = slotOf(oldKeys[i]);
                keys[slot] = oldKeys[i];
                values[slot] = oldValues[i];
            }
        }
    }

    /** Returns the slot of an id, or the empty slot for it. */
    private int slotOf(long id) {
        int slot = Hash.spread(Long.hashCode(id)) & (keys.length - 1);
        while (keys[slot] != id && keys[slot] != 0) {
            slot = after(slot);
        }
        return slot;
    }

    private int after(int slot) {
        return (slot + 1) & (keys.length - 1);
    }
}
