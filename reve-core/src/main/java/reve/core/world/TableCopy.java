package reve.core.world;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;

/** The memory of one table in one slot: written by the world's thread, read by everybody. */
final class TableCopy {

    private static final long ALIGNMENT_BYTES = 64;

    private final Table table;
    private final List<Column> sources;
    private final MemorySegment[] memories;
    private int rowCount;
    private int physicsRowCount;

    TableCopy(Table table) {
        this.table = table;
        this.sources = new ArrayList<>(table.columns());
        this.sources.addFirst(table.ids());
        this.memories = new MemorySegment[sources.size()];
        for (int i = 0; i < memories.length; i++) {
            memories[i] = MemorySegment.NULL;
        }
    }

    /** Copies the used rows; allocates only when the live column has outgrown the copy. */
    void copyFromTable() {
        rowCount = table.rowCount();
        physicsRowCount = table.physicsRowCount();
        for (int i = 0; i < memories.length; i++) {
            Column source = sources.get(i);
            long bytes = (long) rowCount * source.descriptor().rowBytes();
            if (memories[i].byteSize() < bytes) {
                // Collected with the last snapshot that reads it: a reader may still hold the old
                // one.
                memories[i] = Arena.ofAuto().allocate(source.memory().byteSize(), ALIGNMENT_BYTES);
            }
            MemorySegment.copy(source.memory(), 0, memories[i], 0, bytes);
        }
    }

    /**
     * A view of the copy as it is now. If the copy is changing meanwhile the view is nonsense,
     * though safe to make and to read; the slot's stamp tells.
     */
    TableSnapshot view() {
        int rows = rowCount;
        List<ColumnSnapshot> columns = new ArrayList<>(memories.length);
        for (int i = 0; i < memories.length; i++) {
            PropertyDescriptor property = sources.get(i).descriptor();
            MemorySegment memory = memories[i];
            long fitting = memory.byteSize() / property.rowBytes();
            columns.add(new ColumnSnapshot(property, memory, (int) Math.min(rows, fitting)));
        }
        return new TableSnapshot(table.kind(), rows, physicsRowCount, columns.getFirst(),
                columns.subList(1, columns.size()));
    }
}
