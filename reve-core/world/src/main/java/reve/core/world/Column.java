// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;

/** A live column. World's thread only. Values are not checked here; the aspects check them. */
public final class Column extends ColumnView {

    private final Rows rows;
    private final WorldGuard guard;
    private final FrameRecord record;
    private MemorySegment memory;
    private MemorySegment used;
    private long version;

    /** The period of the record in which the last direct edit was noted. */
    private long editNotedIn;

    /**
     * @param rows of the table
     * @param guard asked before each change
     * @param record gets to know of direct edits
     * @param memory zeroed
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

    /** Sets one number; reals are rounded to the column's type, integers keep their low 32 bits. */
    public void setDouble(int row, int component, double value) {
        write(row, component, value);
        noteEdit();
    }

    /** As {@link #setDouble}, by an aspect, which notes the change itself. */
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

    /** As {@link #write}, of all components. */
    void write(int row, double[] values) {
        for (int i = 0; i < values.length; i++) {
            write(row, i, values[i]);
        }
    }

    /** As {@link #write}, in DERIVE; the version is raised only if somebody else has to know. */
    void derive(int row, int component, double value, boolean raiseVersion) {
        long before = version;
        write(row, component, value);
        version = raiseVersion ? version : before;
    }

    /** Sets one I32 or U32. */
    public void setInt(int row, int component, int value) {
        if (type() != ScalarType.I32 && type() != ScalarType.U32) {
            throw wrongType("an integer");
        }
        write(row, component, value);
        noteEdit();
    }

    /** As {@link #setInt}, by an aspect, which notes the change itself. */
    void write(int row, int component, int value) {
        guard.requireEditable();
        memory.set(INT, offset(row, component), value);
        version++;
    }

    /**
     * Raised by every edit in place, so that whoever keeps something computed from the values knows
     * when it is stale. What laws and DERIVE write does not raise it.
     */
    public long version() {
        return version;
    }

    /** Raises the version after values were edited through {@link #segment()}. */
    public void touch() {
        version++;
        noteEdit();
    }

    /** Takes over all rows of a copy, which is a change of the world and not of a column. */
    void restore(MemorySegment rows) {
        MemorySegment.copy(rows, 0, memory, 0, rows.byteSize());
        version++;
    }

    /** Notes direct edits, the first time in a frame. */
    private void noteEdit() {
        if (editNotedIn != record.period()) {
            editNotedIn = record.period();
            record.note(new WorldChange.ColumnEdited(descriptor().kind(), name()));
        }
    }

    /** References are set by the world only, which counts them. */
    void setReference(int row, int component, long value) {
        guard.requireEditable();
        memory.set(LONG, offset(row, component), value);
        version++;
    }

    @Override
    MemorySegment memory() {
        return memory;
    }

    /** Moves to larger memory and returns the old. */
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
