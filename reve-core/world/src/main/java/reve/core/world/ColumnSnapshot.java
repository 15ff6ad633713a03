// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.MemorySegment;

/** A read-only column with the values of a published frame. For any thread. */
public final class ColumnSnapshot extends ColumnView {

    private final MemorySegment segment;
    private final int rows;

    ColumnSnapshot(PropertyDescriptor descriptor, MemorySegment memory, int rows) {
        super(descriptor);
        this.segment = memory.asSlice(0, (long) rows * descriptor.rowBytes()).asReadOnly();
        this.rows = rows;
    }

    @Override
    public int rowCount() {
        return rows;
    }

    @Override
    public MemorySegment segment() {
        return segment;
    }

    @Override
    MemorySegment memory() {
        return segment;
    }
}
