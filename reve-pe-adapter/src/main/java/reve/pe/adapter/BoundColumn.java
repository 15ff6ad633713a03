// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Column;
import reve.core.world.ScalarType;
import reve.core.world.Table;

import java.lang.foreign.MemorySegment;

/** A column that the engine uses in place. */
final class BoundColumn extends BoundProperty {
    private final Column column;
    private long seen;

    BoundColumn(String name, Table table, boolean scenery, Column column) {
        super(name, table, scenery);
        this.column = column;
    }

    @Override
    MemorySegment memory() {
        MemorySegment all = column.segment();
        if (firstRow() == 0) {
            return all; // the object stays the same while no rows move
        }
        return all.asSlice((long) firstRow() * column.descriptor().rowBytes(), bytes());
    }

    /** Zeroes the memory behind the last row. */
    void clearUnused() {
        column.clearUnused();
    }

    /** Returns the type of the numbers. */
    ScalarType type() {
        return column.descriptor().type();
    }

    /** Returns the size of the rows that the engine sees [bytes]. */
    long bytes() {
        return (long) rowCount() * column.descriptor().rowBytes();
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
