// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;

/**
 * A column of a live world, which contains one property of all items of a kind. The column does not
 * check values, because the aspects of items check them. For the world's thread only.
 */
public final class Column extends ColumnView {

    private final Rows rows;
    private final WorldGuard guard;
    private final FrameRecord record;
    private MemorySegment memory;
    private MemorySegment used;
    private long version;

    /**
     * Value of {@link FrameRecord#period} at the last record of a direct edit. Each frame records
     * at most one direct edit of the column.
     */
    private long editNotedIn;

    /**
     * @param rows row count, shared with the table
     * @param guard called before each change
     * @param record receives direct edits, which no aspect of an item makes
     * @param memory zeroed memory for the rows
     */
    Column(
            PropertyDescriptor descriptor,
            Rows rows,
            WorldGuard guard,
            FrameRecord record,
            MemorySegment memory) {
        super(descriptor);
        this.rows = rows;
        this.guard = guard;
        this.record = record;
        this.memory = memory;
        this.used = memory.asSlice(0, 0);
    }

    @Override
    public int rowCount() {
        return rows.count();
    }

    @Override
    public MemorySegment segment() {
        long bytes = (long) rowCount() * descriptor().rowBytes();
        if (used.byteSize() != bytes) {
            used = memory.asSlice(0, bytes);
        }
        return used;
    }

    /**
     * Sets one number. A real number is rounded to the column's type. An integer is reduced to its
     * low 32 bits.
     */
    public void setDouble(int row, int component, double value) {
        write(row, component, value);
        noteEdit();
    }

    /**
     * Sets one number like {@link #setDouble}, without recording the change, because the calling
     * aspect records it.
     */
    void write(int row, int component, double value) {
        guard.requireEditable();
        long offset = offset(row, component);
        switch (type()) {
            case F64 -> memory.set(DOUBLE, offset, value);
            case F32 -> memory.set(FLOAT, offset, (float) value);
            case I32, U32 -> memory.set(INT, offset, (int) (long) value);
            case REF -> throw wrongType("a number");
        }
        version++;
    }

    /** Sets all components like {@link #write}. */
    void write(int row, double[] values) {
        for (int i = 0; i < values.length; i++) {
            write(row, i, values[i]);
        }
    }

    /**
     * Sets one number like {@link #write}, in the phase DERIVE. Increments the version only if
     * {@code raiseVersion} is true.
     */
    void derive(int row, int component, double value, boolean raiseVersion) {
        long before = version;
        write(row, component, value);
        version = raiseVersion ? version : before;
    }

    /** Sets one number of type I32 or U32. */
    public void setInt(int row, int component, int value) {
        if (type() != ScalarType.I32 && type() != ScalarType.U32) {
            throw wrongType("an integer");
        }
        write(row, component, value);
        noteEdit();
    }

    /**
     * Sets one integer like {@link #setInt}, without recording the change, because the calling
     * aspect records it.
     */
    void write(int row, int component, int value) {
        guard.requireEditable();
        memory.set(INT, offset(row, component), value);
        version++;
    }

    /**
     * Returns a version that increases with every edit of the values. A caller compares versions to
     * decide whether to recompute data. Changes by laws and by the phase DERIVE do not increase the
     * version.
     */
    public long version() {
        return version;
    }

    /** Increments the version after values were edited through {@link #segment()}. */
    public void touch() {
        version++;
        noteEdit();
    }

    /** Zeroes the memory behind the last row, because a law may have written there. */
    public void clearUnused() {
        memory.asSlice(segment().byteSize()).fill((byte) 0);
    }

    /**
     * Replaces all rows by those of a {@link WorldImage}. This is not recorded as an edit, because
     * the world records the restoration.
     */
    void restore(MemorySegment rows) {
        MemorySegment.copy(rows, 0, memory, 0, rows.byteSize());
        version++;
    }

    /** Records that the column was edited directly, at most once per frame. */
    private void noteEdit() {
        if (editNotedIn != record.period()) {
            editNotedIn = record.period();
            record.note(new WorldChange.ColumnEdited(descriptor().kind(), name()));
        }
    }

    /**
     * Sets one number of type REF: a reference, or the id of the item in this row. Only {@link
     * References} sets references, because it also counts them.
     */
    void setReference(int row, int component, long value) {
        guard.requireEditable();
        memory.set(LONG, offset(row, component), value);
        version++;
    }

    @Override
    MemorySegment memory() {
        return memory;
    }

    /** Moves the column to larger memory and returns the former memory. */
    MemorySegment moveTo(MemorySegment larger) {
        MemorySegment old = memory;
        MemorySegment.copy(old, 0, larger, 0, (long) rowCount() * descriptor().rowBytes());
        memory = larger;
        used = larger.asSlice(0, 0);
        return old;
    }

    void copyRow(int from, int to) {
        long bytes = descriptor().rowBytes();
        MemorySegment.copy(memory, from * bytes, memory, to * bytes, bytes);
    }

    void clearRows(int first, int count) {
        long bytes = descriptor().rowBytes();
        memory.asSlice(first * bytes, count * bytes).fill((byte) 0);
    }
}
