// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;

/** A read-only table with the rows of a published frame. For one thread. */
public final class TableSnapshot implements TableView {

    private final String kind;
    private final int rowCount;
    private final int physicsRowCount;

    /** The properties of the columns. The first column contains the ids of the items. */
    private final List<PropertyDescriptor> properties;

    private final ColumnBuffers.Buffer[] buffers;

    /**
     * Views of the columns. A view is created when it is first requested, because few readers need
     * all columns.
     */
    private final @Nullable ColumnSnapshot[] made;

    private final Map<Long, Integer> rowById = new HashMap<>();

    TableSnapshot(
            String kind,
            int rowCount,
            int physicsRowCount,
            List<PropertyDescriptor> properties,
            ColumnBuffers.Buffer[] buffers) {
        this.kind = kind;
        this.rowCount = rowCount;
        this.physicsRowCount = physicsRowCount;
        this.properties = properties;
        this.buffers = buffers;
        this.made = new ColumnSnapshot[buffers.length];
    }

    @Override
    public String kind() {
        return kind;
    }

    @Override
    public int rowCount() {
        return rowCount;
    }

    @Override
    public int physicsRowCount() {
        return physicsRowCount;
    }

    /** Returns the column of the items' ids. */
    public ColumnSnapshot ids() {
        return column(0);
    }

    /**
     * Returns the item in a row.
     *
     * @throws IllegalArgumentException if the snapshot was overwritten and the row contains no
     *     valid id
     */
    @Override
    public ItemId idAt(int row) {
        return new ItemId(ids().getReference(row, 0));
    }

    /** Returns the row of an item. The first call searches all rows, and later calls are fast. */
    @Override
    public int rowOf(ItemId id) {
        if (rowById.isEmpty()) {
            ColumnSnapshot ids = ids();
            for (int row = 0; row < rowCount; row++) {
                rowById.put(ids.getReference(row, 0), row);
            }
        }
        return rowById.getOrDefault(id.value(), -1);
    }

    @Override
    public ColumnSnapshot column(String name) {
        for (int i = 1; i < buffers.length; i++) {
            if (properties.get(i).name().equals(name)) {
                return column(i);
            }
        }
        throw new IllegalArgumentException(
                "kind "
                        + kind
                        + " has no property "
                        + name
                        + "; it has "
                        + columns().stream().map(ColumnView::name).toList());
    }

    @Override
    public List<ColumnSnapshot> columns() {
        List<ColumnSnapshot> columns = new ArrayList<>(buffers.length - 1);
        for (int i = 1; i < buffers.length; i++) {
            columns.add(column(i));
        }
        return columns;
    }

    private ColumnSnapshot column(int place) {
        ColumnSnapshot column = made[place];
        if (column == null) {
            PropertyDescriptor property = properties.get(place);
            MemorySegment copy = buffers[place].memory();
            long fitting = copy.byteSize() / property.rowBytes();
            column = new ColumnSnapshot(property, copy, (int) Math.min(rowCount, fitting));
            made[place] = column;
        }
        return column;
    }
}
