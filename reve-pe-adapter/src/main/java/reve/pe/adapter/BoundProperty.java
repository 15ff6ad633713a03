// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Table;
import reve.pe.PhysicalPropertyProvider;

import java.lang.foreign.MemorySegment;

/** A property of the engine and its columns of the world. World's thread only. */
abstract sealed class BoundProperty permits BoundColumn, BoundReferences {
    private final String name;
    private final Table table;
    private boolean added;

    BoundProperty(String name, Table table) {
        this.name = name;
        this.table = table;
    }

    /** Returns the engine's name of the property. */
    final String name() {
        return name;
    }

    /** Returns the table; its rows [0, physicsRowCount) are the engine's rows. */
    final Table table() {
        return table;
    }

    /** Rebinds the memory after rows were added, removed or moved, or the memory was replaced. */
    final void bind(PhysicalPropertyProvider provider) {
        if (added) {
            provider.rebindPhysicalProperty(name, memory(), table.physicsRowCount());
        } else {
            provider.addPhysicalProperty(name, memory(), table.physicsRowCount());
            added = true;
        }
        markSeen();
    }

    /** Notifies the engine if values were edited since the last notification. */
    final void touchIfEdited(PhysicalPropertyProvider provider) {
        if (isEdited()) {
            memory();
            provider.touch(name);
            markSeen();
        }
    }

    /** Returns current memory of at least (physicsRowCount x components) values. */
    abstract MemorySegment memory();

    /** Returns true if a column was edited in place since {@link #markSeen}. */
    abstract boolean isEdited();

    abstract void markSeen();
}
