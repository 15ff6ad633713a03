// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import java.util.concurrent.atomic.AtomicLong;

/**
 * Hands entries from the world's thread to the writer's, in their order, without a lock and without
 * allocating.
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

    // ---- world's thread ----

    /** The next entry to fill, or null if all are waiting. */
    @Nullable Entry next() {
        return isFull() ? null : entries[(int) (written.getPlain() % entries.length)];
    }

    boolean isFull() {
        return written.getPlain() - read.getAcquire() == entries.length;
    }

    /** Whether the other thread is done with all that it was handed. */
    boolean isEmpty() {
        return written.getPlain() == read.getAcquire();
    }

    /** Hands the filled entry over. */
    void commit() {
        written.setRelease(written.getPlain() + 1);
    }

    // ---- writer's thread ----

    /** The oldest entry that waits, or null. */
    @Nullable Entry peek() {
        return read.getPlain() == written.getAcquire()
                ? null
                : entries[(int) (read.getPlain() % entries.length)];
    }

    /** Gives that entry back. */
    void release() {
        entries[(int) (read.getPlain() % entries.length)].clear();
        read.setRelease(read.getPlain() + 1);
    }
}
