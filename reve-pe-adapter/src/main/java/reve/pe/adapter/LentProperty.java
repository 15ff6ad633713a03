// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Table;
import reve.pe.PhysicalPropertyProvider;

import java.lang.foreign.MemorySegment;

/** A property of the engine and the world's columns behind it. World's thread only. */
abstract sealed class LentProperty permits LentColumn, LentReferences {
    private final String name;
    private final Table table;
    private boolean added;

    LentProperty(String name, Table table) {
        this.name = name;
        this.table = table;
    }

    /** The engine's name for it. */
    final String name() {
        return name;
    }

    /** Rows [0, physicsRowCount) of this table are the engine's rows. */
    final Table table() {
        return table;
    }

    /** Lends the memory anew: rows came, went or moved, or the memory was replaced. */
    final void lend(PhysicalPropertyProvider provider) {
        if (added) {
            provider.rebindPhysicalProperty(name, memory(), table.physicsRowCount());
        } else {
            provider.addPhysicalProperty(name, memory(), table.physicsRowCount());
            added = true;
        }
        markSeen();
    }

    /** Tells the engine if values were edited since it was told last. */
    final void touchIfEdited(PhysicalPropertyProvider provider) {
        if (isEdited()) {
            memory();
            provider.touch(name);
            markSeen();
        }
    }

    /** Memory of at least (physicsRowCount x components), brought up to date. */
    abstract MemorySegment memory();

    /** True if a column was edited in place since {@link #markSeen}. */
    abstract boolean isEdited();

    abstract void markSeen();
}
