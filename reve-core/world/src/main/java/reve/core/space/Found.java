// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.util.Arrays;
import java.util.Objects;
import java.util.function.LongPredicate;

/**
 * The keys that a query of a {@link BoxIndex} has found. The object can be used for further
 * queries. For one thread.
 */
public final class Found {

    private long[] keys = new long[16];
    private int size;

    /** Returns the number of keys. */
    public int size() {
        return size;
    }

    /**
     * Returns a key.
     *
     * @param index 0 to {@link #size()} - 1
     */
    public long key(int index) {
        return keys[Objects.checkIndex(index, size)];
    }

    /** Removes the keys for which a test is false. The other keys stay in their order. */
    public void keepIf(LongPredicate test) {
        int kept = 0;
        for (int i = 0; i < size; i++) {
            if (test.test(keys[i])) {
                keys[kept++] = keys[i];
            }
        }
        size = kept;
    }

    void clear() {
        size = 0;
    }

    void add(long key) {
        if (size == keys.length) {
            keys = Arrays.copyOf(keys, 2 * size);
        }
        keys[size++] = key;
    }

    void sort() {
        Arrays.sort(keys, 0, size);
    }
}
