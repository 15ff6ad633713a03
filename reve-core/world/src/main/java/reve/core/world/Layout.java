// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;

/**
 * The layout of all tables: a version, and the former memory of columns. The version increases when
 * rows or column memory have moved. The former memory is freed later. For the world's thread only.
 */
final class Layout {

    private final ColumnArena arena;
    private final List<MemorySegment> replaced = new ArrayList<>();
    private long version;

    Layout(ColumnArena arena) {
        this.arena = arena;
    }

    MemorySegment reserve(String columnName, long bytes) {
        return arena.reserve(columnName, bytes);
    }

    /** Keeps the former memory of a column until {@link #releaseReplaced()}. */
    void replace(MemorySegment memory) {
        replaced.add(memory);
        version++;
    }

    /** Records that rows were added, removed or moved, or items were attached or detached. */
    void changed() {
        version++;
    }

    /**
     * Returns the version, which increases when rows are added, removed or moved, items are
     * attached or detached, or column memory is replaced.
     */
    long version() {
        return version;
    }

    /** Frees the former memory of columns. No code may access this memory after the call. */
    void releaseReplaced() {
        for (int i = 0; i < replaced.size(); i++) {
            arena.release(replaced.get(i));
        }
        replaced.clear();
    }
}
