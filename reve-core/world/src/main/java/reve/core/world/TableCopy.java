// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;
import java.util.Arrays;
import java.util.List;
import java.util.function.LongFunction;

/** A copy of the rows of one table, column by column, in a {@link WorldImage}. */
public final class TableCopy {

    private final String kind;
    private final List<PropertyDescriptor> properties;
    private final LongFunction<MemorySegment> allocate;
    private final MemorySegment[] memories;
    private int rowCount;
    private int physicsRowCount;

    /**
     * @param allocate gives memory for that many bytes; what is outgrown is left to its owner
     */
    TableCopy(Table table, LongFunction<MemorySegment> allocate) {
        this.kind = table.kind();
        this.properties = table.allColumns().stream().map(Column::descriptor).toList();
        this.allocate = allocate;
        this.memories = new MemorySegment[properties.size()];
        Arrays.fill(memories, MemorySegment.NULL);
    }

    /** The kind whose rows these are. */
    public String kind() {
        return kind;
    }

    /** Rows of the table. */
    public int rowCount() {
        return rowCount;
    }

    /** How many rows, the first ones, take part in physics. */
    public int physicsRowCount() {
        return physicsRowCount;
    }

    /** What each column is, in a fixed order; the first holds the items' ids. */
    public List<PropertyDescriptor> properties() {
        return properties;
    }

    /** The used rows of a column (rows x components), packed, in native byte order. */
    public MemorySegment column(int index) {
        return memories[index].asSlice(0, bytes(index, rowCount));
    }

    /** Bytes of all used rows. */
    public long bytes() {
        long sum = 0;
        for (int i = 0; i < memories.length; i++) {
            sum += bytes(i, rowCount);
        }
        return sum;
    }

    /** Makes room for rows whose values the caller writes next; the old values are gone. */
    public void resize(int rows, int physicsRows) {
        if (rows < 0 || physicsRows < 0 || physicsRows > rows) {
            throw new IllegalArgumentException(
                    "table "
                            + kind
                            + " of "
                            + rows
                            + " rows, of which "
                            + physicsRows
                            + " are physical");
        }
        for (int i = 0; i < memories.length; i++) {
            makeRoom(i, bytes(i, rows), bytes(i, rows));
        }
        rowCount = rows;
        physicsRowCount = physicsRows;
    }

    /** Copies the used rows; allocates only when the live column has outgrown the copy. */
    void copyFrom(Table table) {
        List<Column> sources = table.allColumns();
        rowCount = table.rowCount();
        physicsRowCount = table.physicsRowCount();
        for (int i = 0; i < memories.length; i++) {
            MemorySegment source = sources.get(i).memory();
            long bytes = bytes(i, rowCount);
            makeRoom(i, bytes, source.byteSize());
            MemorySegment.copy(source, 0, memories[i], 0, bytes);
        }
    }

    /**
     * @throws IllegalArgumentException naming what differs if the copy is of no such table
     */
    void requireOf(Table table) {
        List<PropertyDescriptor> expected =
                table.allColumns().stream().map(Column::descriptor).toList();
        if (!table.kind().equals(kind) || !expected.equals(properties)) {
            throw new IllegalArgumentException(
                    "the image is of a world with another prototype: "
                            + "kind "
                            + kind
                            + " has the properties "
                            + names(properties)
                            + ", expected kind "
                            + table.kind()
                            + " with "
                            + names(expected));
        }
    }

    private static List<String> names(List<PropertyDescriptor> properties) {
        return properties.stream().map(PropertyDescriptor::name).toList();
    }

    private long bytes(int column, int rows) {
        return (long) rows * properties.get(column).rowBytes();
    }

    private void makeRoom(int column, long atLeast, long wanted) {
        if (memories[column].byteSize() < atLeast) {
            memories[column] = allocate.apply(wanted);
        }
    }
}
