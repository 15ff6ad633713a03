// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.world.ColumnArena;
import reve.core.world.ItemId;
import reve.core.world.Table;
import reve.core.world.World;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;

/**
 * For each row the engine's row of the body with physics that the item is attached to, directly or
 * not, and -1 for an item that is attached to nothing or to scenery. Attachments change the layout
 * of the world, so that this property is then bound again.
 */
final class BoundCarriers extends BoundProperty {
    private static final int NONE = -1;

    private final World world;
    private final ColumnArena arena;
    private @Nullable MemorySegment rows;

    BoundCarriers(String name, World world, Table table, boolean scenery, ColumnArena arena) {
        super(name, table, scenery);
        this.world = world;
        this.arena = arena;
    }

    @Override
    MemorySegment memory() {
        MemorySegment memory = roomFor(rowCount());
        for (int row = 0; row < rowCount(); row++) {
            memory.setAtIndex(ValueLayout.JAVA_INT, row, carrier(table().idAt(firstRow() + row)));
        }
        return memory;
    }

    @Override
    boolean isEdited() {
        return false;
    }

    @Override
    void markSeen() {}

    private int carrier(ItemId item) {
        ItemId root = item;
        for (ItemId next = item; next != null; next = world.item(next).parent().orElse(null)) {
            root = next;
        }
        int row = root.equals(item) ? NONE : table().rowOf(root);
        return row < table().physicsRowCount() ? row : NONE;
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
