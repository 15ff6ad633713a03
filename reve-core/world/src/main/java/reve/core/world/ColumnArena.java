// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;

/**
 * Allocator of the memory for a world's columns. The world allocates memory when items are added.
 * The arena must outlive the world. Only the world's thread uses the arena and its memory.
 */
public interface ColumnArena extends AutoCloseable {

    /**
     * Allocates zeroed memory that begins at a page (a multiple of 4096 bytes). The memory does not
     * move until it is released.
     *
     * @param name purpose of the memory, for example {@code body.mass}
     * @param bytes size, at least 1
     * @throws IllegalStateException naming the column if there is not enough memory
     */
    MemorySegment reserve(String name, long bytes);

    /**
     * Frees memory from {@link #reserve}. The world frees the old memory of a column that has moved
     * to larger memory at the end of the next PHYSICS phase. The engine uses the new memory by
     * then.
     */
    void release(MemorySegment memory);

    /** Frees all memory. The columns of the world are invalid afterwards. */
    @Override
    void close();
}
