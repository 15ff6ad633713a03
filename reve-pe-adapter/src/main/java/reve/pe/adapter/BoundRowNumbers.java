// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.world.ColumnArena;
import reve.core.world.Table;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;

/**
 * A property that contains, for each row of bodies or of scenery, a row number that the adapter
 * computes; -1 for none.
 */
abstract sealed class BoundRowNumbers extends BoundProperty
        permits BoundCarriers, BoundMeshes.Rows {
    static final int NONE = -1;

    private final ColumnArena arena;
    private @Nullable MemorySegment rows;

    BoundRowNumbers(String name, Table table, boolean scenery, ColumnArena arena) {
        super(name, table, scenery);
        this.arena = arena;
    }

    /** Returns the number for a row of the table. */
    abstract int numberOf(int tableRow);

    @Override
    final MemorySegment memory() {
        MemorySegment memory = roomFor(rowCount());
        for (int row = 0; row < rowCount(); row++) {
            memory.setAtIndex(ValueLayout.JAVA_INT, row, numberOf(firstRow() + row));
        }
        return memory;
    }

    /** Returns memory for rows. The caller rebinds before the engine runs. */
    private MemorySegment roomFor(int count) {
        long bytes = Math.max(1L, count) * Integer.BYTES;
        if (rows == null || rows.byteSize() < bytes) {
            if (rows != null) {
                arena.release(rows);
            }
            rows =
                    arena.reserve(
                            table().kind() + "." + name(),
                            Math.max(bytes, rows == null ? 0 : 2 * rows.byteSize()));
        }
        return rows;
    }
}
