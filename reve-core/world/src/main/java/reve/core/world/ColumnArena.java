// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;

/**
 * Where a world's column memory comes from. The world reserves when it grows, never during a frame.
 * The arena outlives the world; both are used by the world's thread only.
 */
public interface ColumnArena extends AutoCloseable {

    /**
     * Reserves zeroed memory that begins at a page (a multiple of 4096 bytes) and stays where it is
     * until it is released.
     *
     * @param name what the memory is for, for example {@code body.mass}
     * @param bytes size, at least 1
     * @throws IllegalStateException naming the column if there is no more memory
     */
    MemorySegment reserve(String name, long bytes);

    /**
     * Takes back what {@link #reserve} gave. After a column moved to larger memory the world calls
     * it when the next PHYSICS is over, so that whoever works on the columns could let go before.
     */
    void release(MemorySegment memory);

    /** Frees everything; no column of a world that uses this arena may be touched afterwards. */
    @Override
    void close();
}
