// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;

/**
 * Allocator of a world's column memory. The world allocates when it grows, never during a frame.
 * The arena outlives the world; only the world's thread uses both.
 */
public interface ColumnArena extends AutoCloseable {

    /**
     * Allocates zeroed memory that begins at a page (a multiple of 4096 bytes) and does not move
     * until it is released.
     *
     * @param name purpose of the memory, for example {@code body.mass}
     * @param bytes size, at least 1
     * @throws IllegalStateException naming the column if there is not enough memory
     */
    MemorySegment reserve(String name, long bytes);

    /**
     * Frees memory from {@link #reserve}. After a column has moved to larger memory, the world
     * calls this at the end of the next PHYSICS, so that users of the column can bind the new
     * memory first.
     */
    void release(MemorySegment memory);

    /** Frees all memory; columns of a world that uses this arena are invalid afterwards. */
    @Override
    void close();
}
