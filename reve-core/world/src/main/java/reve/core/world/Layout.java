// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;

/**
 * Where the rows of all tables are: the memory of their columns, and a version that tells whoever
 * holds rows or memory that these have moved. World's thread.
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

    /** Keeps memory that a column left until {@link #releaseReplaced()}. */
    void replace(MemorySegment memory) {
        replaced.add(memory);
        version++;
    }

    /** Rows were added, removed or moved. */
    void rowsMoved() {
        version++;
    }

    /** Raised whenever rows were added, removed or moved, or column memory was replaced. */
    long version() {
        return version;
    }

    /** Frees memory that was replaced; all have let go of it. */
    void releaseReplaced() {
        for (int i = 0; i < replaced.size(); i++) {
            arena.release(replaced.get(i));
        }
        replaced.clear();
    }
}
