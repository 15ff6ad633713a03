// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.world.Column;
import reve.core.world.ColumnArena;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.Table;
import reve.core.world.World;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.List;

/**
 * References in the form of the engine: U32 rows of the target table (physicsRowCount x
 * components). The world stores item ids in one or more columns.
 */
final class BoundReferences extends BoundProperty {
    private final World world;
    private final Table target;
    private final List<Column> columns;
    private final int components;
    private final ColumnArena arena;
    private final long[] seen;
    private @Nullable MemorySegment rows;

    /**
     * @param columns columns of references to items of the target table; they are side by side in
     *     the property
     */
    BoundReferences(
            String name,
            World world,
            Table table,
            Table target,
            List<Column> columns,
            ColumnArena arena) {
        super(name, table, false);
        this.world = world;
        this.target = target;
        this.columns = columns;
        this.components = columns.stream().mapToInt(Column::components).sum();
        this.arena = arena;
        this.seen = new long[columns.size()];
    }

    /** Resolves all references, and returns the rows. */
    @Override
    MemorySegment memory() {
        MemorySegment memory = roomFor((long) table().physicsRowCount() * components);
        int at = 0;
        for (int row = 0; row < table().physicsRowCount(); row++) {
            for (Column column : columns) {
                for (int component = 0; component < column.components(); component++) {
                    memory.setAtIndex(
                            ValueLayout.JAVA_INT, at++, rowReferredTo(column, row, component));
                }
            }
        }
        return memory;
    }

    @Override
    boolean isEdited() {
        for (int i = 0; i < seen.length; i++) {
            if (columns.get(i).version() != seen[i]) {
                return true;
            }
        }
        return false;
    }

    @Override
    void markSeen() {
        for (int i = 0; i < seen.length; i++) {
            seen[i] = columns.get(i).version();
        }
    }

    /**
     * Returns memory for references. Frees replaced memory at once, because the caller rebinds
     * before the engine runs.
     */
    private MemorySegment roomFor(long references) {
        long bytes = Math.max(1, references) * Integer.BYTES;
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

    private int rowReferredTo(Column column, int row, int component) {
        long id = column.getReference(row, component);
        int found = id == 0 ? -1 : target.rowOf(new ItemId(id));
        if (found < 0 || found >= target.physicsRowCount()) {
            Item item = world.item(table().idAt(row));
            throw new IllegalStateException(
                    item
                            + ": "
                            + column.name()
                            + " refers to "
                            + (found < 0
                                    ? "nothing"
                                    : world.item(new ItemId(id)) + ", which has no physics aspect")
                            + ", expected a "
                            + target.kind()
                            + " with physics");
        }
        return found;
    }
}
