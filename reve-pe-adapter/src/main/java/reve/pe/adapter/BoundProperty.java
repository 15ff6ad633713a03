// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.Table;
import reve.pe.PhysicalPropertyProvider;

import java.lang.foreign.MemorySegment;

/** A property of the engine and its columns of the world. For the world's thread only. */
abstract sealed class BoundProperty
        permits BoundColumn, BoundReferences, BoundRowNumbers, BoundMeshes.Data {
    private final String name;
    private final Table table;
    private final boolean scenery;
    private boolean added;

    /**
     * @param scenery whether the engine's rows of this property are the items without a physics
     *     aspect
     */
    BoundProperty(String name, Table table, boolean scenery) {
        this.name = name;
        this.table = table;
        this.scenery = scenery;
    }

    /** Returns the engine's name of the property. */
    final String name() {
        return name;
    }

    /** Returns the table, which has the engine's rows. */
    final Table table() {
        return table;
    }

    /** Returns the first of the engine's rows in the table. */
    final int firstRow() {
        return scenery ? table.physicsRowCount() : 0;
    }

    /** Returns the number of the engine's rows. */
    int rowCount() {
        return scenery ? table.rowCount() - table.physicsRowCount() : table.physicsRowCount();
    }

    /** Rebinds the memory after rows were added, removed or moved, or the memory was replaced. */
    final void bind(PhysicalPropertyProvider provider) {
        if (added) {
            provider.rebindPhysicalProperty(name, memory(), rowCount());
        } else {
            provider.addPhysicalProperty(name, memory(), rowCount());
            added = true;
        }
        markSeen();
    }

    /** Returns whether the engine has the property. */
    final boolean isBound() {
        return added;
    }

    /** Removes the property from the engine, if the engine has it. */
    final void unbind(PhysicalPropertyProvider provider) {
        if (added) {
            provider.removePhysicalProperty(name);
            added = false;
        }
    }

    /**
     * Notifies the engine if values of a bound property were edited since the last notification.
     */
    final void touchIfEdited(PhysicalPropertyProvider provider) {
        if (isEdited()) {
            memory();
            provider.touch(name);
            markSeen();
        }
    }

    /** Returns current memory of at least (rowCount x components) values. */
    abstract MemorySegment memory();

    /** Returns true if a column was edited in place since {@link #markSeen}. */
    abstract boolean isEdited();

    abstract void markSeen();
}
