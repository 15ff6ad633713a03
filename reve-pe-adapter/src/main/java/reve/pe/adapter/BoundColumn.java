// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Column;
import reve.core.world.Table;

import java.lang.foreign.MemorySegment;

/** A column that the engine uses in place. */
final class BoundColumn extends BoundProperty {
    private final Column column;
    private long seen;

    BoundColumn(String name, Table table, Column column) {
        super(name, table);
        this.column = column;
    }

    @Override
    MemorySegment memory() {
        return column.segment();
    }

    /** Zeroes the memory behind the last row. */
    void clearUnused() {
        column.clearUnused();
    }

    @Override
    boolean isEdited() {
        return column.version() != seen;
    }

    @Override
    void markSeen() {
        seen = column.version();
    }
}
