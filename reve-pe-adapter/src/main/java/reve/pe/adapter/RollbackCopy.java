// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.List;

/**
 * A copy of columns at the beginning of a frame. It contains the whole memory of the columns,
 * including the memory after the last row in use. A faulty law may write to this memory before it
 * crashes. For the world's thread only.
 */
final class RollbackCopy implements AutoCloseable {
    private static final long ALIGNMENT_BYTES = 64;

    private Arena arena = Arena.ofShared();
    private MemorySegment copy = MemorySegment.NULL;
    private BoundColumn[] columns = {};

    /**
     * Sets the columns to copy. Allocates memory only if these columns need more memory than
     * earlier columns.
     */
    void keep(List<BoundColumn> wanted) {
        columns = wanted.toArray(BoundColumn[]::new);
        long bytes = 0;
        for (BoundColumn column : columns) {
            bytes += aligned(column.memory().byteSize());
        }
        if (bytes > copy.byteSize()) {
            arena.close();
            arena = Arena.ofShared();
            copy = arena.allocate(Math.max(bytes, 2 * copy.byteSize()), ALIGNMENT_BYTES);
        }
    }

    void save() {
        long at = 0;
        for (BoundColumn column : columns) {
            MemorySegment from = column.memory();
            MemorySegment.copy(from, 0, copy, at, from.byteSize());
            at += aligned(from.byteSize());
        }
    }

    void restore() {
        long at = 0;
        for (BoundColumn column : columns) {
            MemorySegment to = column.memory();
            MemorySegment.copy(copy, at, to, 0, to.byteSize());
            column.clearUnused();
            at += aligned(to.byteSize());
        }
    }

    @Override
    public void close() {
        columns = new BoundColumn[0];
        copy = MemorySegment.NULL;
        if (arena.scope().isAlive()) {
            arena.close();
        }
    }

    private static long aligned(long bytes) {
        return (bytes + ALIGNMENT_BYTES - 1) / ALIGNMENT_BYTES * ALIGNMENT_BYTES;
    }
}
