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
     * Creates an empty copy.
     *
     * @param allocate returns memory with the given number of bytes, which this class never frees
     */
    TableCopy(Table table, LongFunction<MemorySegment> allocate) {
        this.kind = table.kind();
        this.properties = table.allColumns().stream().map(Column::descriptor).toList();
        this.allocate = allocate;
        this.memories = new MemorySegment[properties.size()];
        Arrays.fill(memories, MemorySegment.NULL);
    }

    /** Returns the kind of the rows. */
    public String kind() {
        return kind;
    }

    /** Returns the number of rows. */
    public int rowCount() {
        return rowCount;
    }

    /** Returns the number of rows with a physics aspect. These rows are the first ones. */
    public int physicsRowCount() {
        return physicsRowCount;
    }

    /**
     * Returns the properties of the columns, in a fixed order. The first column contains the items'
     * ids.
     */
    public List<PropertyDescriptor> properties() {
        return properties;
    }

    /** Returns the used rows of a column (rows x components), packed, in native byte order. */
    public MemorySegment column(int index) {
        return memories[index].asSlice(0, bytes(index, rowCount));
    }

    /** Returns the size of all used rows [bytes]. */
    public long bytes() {
        long sum = 0;
        for (int i = 0; i < memories.length; i++) {
            sum += bytes(i, rowCount);
        }
        return sum;
    }

    /**
     * Sets the number of rows. If it changes, the old values are lost, so the caller must then
     * write all values. Memory that is too small is replaced by at least twice as much, because it
     * is freed only with the image.
     */
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
            makeRoom(i, bytes(i, rows), Math.max(bytes(i, rows), 2 * memories[i].byteSize()));
        }
        rowCount = rows;
        physicsRowCount = physicsRows;
    }

    /**
     * Copies the used rows. Allocates memory only if the live column is larger than the memory of
     * the copy.
     */
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
     * Checks that the copy matches a table.
     *
     * @throws IllegalArgumentException naming the difference if the copy does not match the table
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
