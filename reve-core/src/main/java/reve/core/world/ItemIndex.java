package reve.core.world;

import java.util.Arrays;
import java.util.function.Function;
import org.jspecify.annotations.Nullable;

/**
 * Items by something that each has and no two share. A hash table of the items themselves, by
 * linear probing: a reference or two an item. World's thread only.
 */
final class ItemIndex<K> {

    private static final int INITIAL_SLOTS = 64;
    /** 2^32 over the golden ratio: keys that follow each other come to lie far apart. */
    private static final int SPREAD = 0x9E3779B9;

    private final Function<Item, K> keyOf;
    private @Nullable Item[] slots = new Item[INITIAL_SLOTS];
    private int size;

    /** @param keyOf stays what it is while the item is in here */
    ItemIndex(Function<Item, K> keyOf) {
        this.keyOf = keyOf;
    }

    @Nullable Item find(K key) {
        return slots[slotOf(key)];
    }

    /** Adds an item whose key no other has. */
    void add(Item item) {
        if (4 * ++size > 3 * slots.length) {
            Item[] before = slots;
            slots = new Item[2 * before.length];
            for (Item other : before) {
                if (other != null) {
                    put(other);
                }
            }
        }
        put(item);
    }

    /** Removes an item that is in here. */
    void remove(Item item) {
        int gap = slotOf(keyOf.apply(item));
        slots[gap] = null;
        size--;
        // What was put behind the gap because of the item moves up.
        int mask = slots.length - 1;
        Item next;
        for (int i = (gap + 1) & mask; (next = slots[i]) != null; i = (i + 1) & mask) {
            slots[i] = null;
            put(next);
        }
    }

    void clear() {
        Arrays.fill(slots, null);
        size = 0;
    }

    private void put(Item item) {
        slots[slotOf(keyOf.apply(item))] = item;
    }

    /** Where the item of a key is, or where it would go. */
    private int slotOf(K key) {
        int mask = slots.length - 1;
        int slot = key.hashCode() * SPREAD >>> Integer.numberOfLeadingZeros(mask);
        Item there;
        while ((there = slots[slot]) != null && !keyOf.apply(there).equals(key)) {
            slot = (slot + 1) & mask;
        }
        return slot;
    }
}
