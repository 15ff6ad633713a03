// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.Arrays;
import java.util.List;

/**
 * A copy of one table's rows in one slot of a {@link SnapshotRing}. The world's thread writes the
 * copy, and any thread reads it. A column that is equal to that of the previous frame shares the
 * memory of the previous frame's slot. All columns of zeros share one memory.
 */
final class SlotTable {

    private final String kind;
    private final List<PropertyDescriptor> properties;
    private final List<ColumnBuffers> memory;
    private final ColumnBuffers.Buffer[] buffers;
    private final Zeros zeros;
    private int rowCount;
    private int physicsRowCount;

    /**
     * @param memory the buffers of each column, shared by all slots of the ring
     */
    SlotTable(Table table, List<ColumnBuffers> memory, Zeros zeros) {
        this.kind = table.kind();
        this.properties = table.allColumns().stream().map(Column::descriptor).toList();
        this.memory = memory;
        this.zeros = zeros;
        this.buffers = new ColumnBuffers.Buffer[properties.size()];
        Arrays.fill(buffers, ColumnBuffers.NONE);
    }

    /** Copies the used rows. Allocates memory only if a column has grown. */
    void copyFrom(Table table, @Nullable SlotTable before) {
        List<Column> sources = table.allColumns();
        rowCount = table.rowCount();
        physicsRowCount = table.physicsRowCount();
        for (int i = 0; i < buffers.length; i++) {
            letGo(i);
            MemorySegment source = sources.get(i).memory();
            long bytes = (long) rowCount * properties.get(i).rowBytes();
            if (before != null
                    && before.rowCount == rowCount
                    && isSame(source, before.buffers[i].memory(), bytes)) {
                buffers[i] = memory.get(i).share(before.buffers[i]);
            } else if (isZero(source, bytes)) {
                buffers[i] = memory.get(i).share(zeros.of(bytes));
            } else {
                buffers[i] = memory.get(i).take(bytes);
                MemorySegment.copy(source, 0, buffers[i].memory(), 0, bytes);
            }
        }
    }

    /**
     * Returns a view of the copy. The world's thread may overwrite the copy while it is read.
     * Reading is then safe, but the values are invalid. The stamp of the slot shows this to the
     * reader.
     */
    TableSnapshot view() {
        return new TableSnapshot(kind, rowCount, physicsRowCount, properties, buffers.clone());
    }

    private void letGo(int column) {
        memory.get(column).release(buffers[column]);
        buffers[column] = ColumnBuffers.NONE;
    }

    /** Returns whether all bytes are 0. */
    private static boolean isZero(MemorySegment memory, long bytes) {
        return bytes == 0
                || memory.get(ValueLayout.JAVA_BYTE, 0) == 0
                        && MemorySegment.mismatch(memory, 0, bytes - 1, memory, 1, bytes) < 0;
    }

    private static boolean isSame(MemorySegment a, MemorySegment b, long bytes) {
        return b.byteSize() >= bytes && MemorySegment.mismatch(a, 0, bytes, b, 0, bytes) < 0;
    }
}
