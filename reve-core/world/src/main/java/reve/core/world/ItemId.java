// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * Identity of an item during the life of its world: a positive number that is never reused. Later
 * items have higher numbers.
 */
public record ItemId(long value) implements Comparable<ItemId> {

    /** Checks that the number is positive. */
    public ItemId {
        if (value <= 0) {
            throw new IllegalArgumentException("item id " + value + ": expected a positive number");
        }
    }

    @Override
    public int compareTo(ItemId other) {
        return Long.compare(value, other.value);
    }

    @Override
    public String toString() {
        return "#" + value;
    }
}
