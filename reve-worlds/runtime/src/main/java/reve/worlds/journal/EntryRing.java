// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import java.util.concurrent.atomic.AtomicLong;

/**
 * A ring that passes entries in order from the world's thread to the writer's thread, without a
 * lock and without allocation.
 */
final class EntryRing {
    private final Entry[] entries;
    private final AtomicLong written = new AtomicLong();
    private final AtomicLong read = new AtomicLong();

    EntryRing(int capacity, int digestSize) {
        entries = new Entry[capacity];
        for (int i = 0; i < capacity; i++) {
            entries[i] = new Entry(digestSize);
        }
    }

    // ---- methods for the world's thread ----

    /** Returns the next entry to fill, or null if all entries still wait for the writer. */
    @Nullable Entry next() {
        return isFull() ? null : entries[(int) (written.getPlain() % entries.length)];
    }

    boolean isFull() {
        return written.getPlain() - read.getAcquire() == entries.length;
    }

    /** Returns whether the ring is empty, that is, whether the writer has released all entries. */
    boolean isEmpty() {
        return written.getPlain() == read.getAcquire();
    }

    /** Passes the filled entry to the writer. */
    void commit() {
        written.setRelease(written.getPlain() + 1);
    }

    // ---- methods for the writer's thread ----

    /** Returns the oldest waiting entry, or null. */
    @Nullable Entry peek() {
        return read.getPlain() == written.getAcquire()
                ? null
                : entries[(int) (read.getPlain() % entries.length)];
    }

    /** Makes the oldest entry available to the world's thread again. */
    void release() {
        entries[(int) (read.getPlain() % entries.length)].clear();
        read.setRelease(read.getPlain() + 1);
    }
}
