// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.Arrays;
import java.util.function.Function;

/**
 * A hash table from unique keys to items, with linear probing. It needs the memory of one or two
 * references per item, because each item contains its key. For the world's thread only.
 */
final class ItemIndex<K> {

    private static final int INITIAL_SLOTS = 64;

    private final Function<Item, K> keyOf;
    private @Nullable Item[] slots = new Item[INITIAL_SLOTS];
    private int size;

    /**
     * @param keyOf returns the key of an item, which must not change while the item is in the table
     */
    ItemIndex(Function<Item, K> keyOf) {
        this.keyOf = keyOf;
    }

    @Nullable Item find(K key) {
        return slots[slotOf(key)];
    }

    /** Adds an item with a unique key. */
    void add(Item item) {
        makeRoom(1);
        put(item);
        size++;
    }

    /** Allocates space for {@code more} further items. */
    void makeRoom(int more) {
        int wanted = slots.length;
        while (5L * (size + more) > 4L * wanted) {
            wanted = Math.multiplyExact(wanted, 2);
        }
        if (wanted > slots.length) {
            Item[] before = slots;
            slots = new Item[wanted];
            for (Item item : before) {
                if (item != null) {
                    put(item);
                }
            }
        }
    }

    /** Removes an item, which must be in the table. */
    void remove(Item item) {
        int gap = slotOf(keyOf.apply(item));
        slots[gap] = null;
        size--;
        // A later entry may be in its slot only because the slot of the removed entry was occupied.
        // Such an entry moves into the gap, because searches would not find it otherwise.
        Item next;
        for (int i = after(gap); (next = slots[i]) != null; i = after(i)) {
            slots[i] = null;
            put(next);
        }
    }

    void clear() {
        Arrays.fill(slots, null);
        size = 0;
    }

    private void put(Item item) {
        int slot = start(keyOf.apply(item));
        while (slots[slot] != null) {
            slot = after(slot);
        }
        slots[slot] = item;
    }

    /** Returns the slot of a key, or the empty slot for it. */
    private int slotOf(K key) {
        int slot = start(key);
        Item present;
        while ((present = slots[slot]) != null && !keyOf.apply(present).equals(key)) {
            slot = after(slot);
        }
        return slot;
    }

    private int start(K key) {
        return Hash.spread(key.hashCode()) & (slots.length - 1);
    }

    private int after(int slot) {
        return (slot + 1) & (slots.length - 1);
    }
}
