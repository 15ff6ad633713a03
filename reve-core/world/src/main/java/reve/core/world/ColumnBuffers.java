// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;

/**
 * The memory for copies of one column in the slots of a {@link SnapshotRing}. Slots whose bytes are
 * equal share one buffer. For the world's thread only.
 */
final class ColumnBuffers {

    private static final long ALIGNMENT_BYTES = 64;

    /**
     * Divisor that determines the reserve of a new buffer. A buffer for a column that has grown
     * gets an eighth more bytes than needed, so that not every frame allocates a new buffer.
     */
    private static final int SLACK = 8;

    /**
     * A copy of a column, and the number of slots that hold the copy. The number has no effect for
     * a constant buffer, because such a buffer is never reused.
     */
    static final class Buffer {
        private final MemorySegment memory;
        private final boolean constant;
        private int slots;

        private Buffer(MemorySegment memory, boolean constant) {
            this.memory = memory;
            this.constant = constant;
        }

        MemorySegment memory() {
            return memory;
        }
    }

    /** The buffer of a slot to which nothing was written yet. */
    static final Buffer NONE = new Buffer(MemorySegment.NULL, true);

    private final List<Buffer> idle = new ArrayList<>();
    private long largest;

    /** Records that one more slot holds the buffer, and returns the buffer. */
    Buffer share(Buffer buffer) {
        buffer.slots++;
        return buffer;
    }

    /**
     * Returns an unused buffer or a new one, and records that one slot holds it. Discards unused
     * buffers that are too small.
     */
    Buffer take(long bytes) {
        while (!idle.isEmpty()) {
            Buffer buffer = idle.removeLast();
            if (buffer.memory.byteSize() >= bytes) {
                return share(buffer);
            }
        }
        long room = largest > 0 && bytes > largest ? bytes + bytes / SLACK : bytes;
        largest = Math.max(largest, room);
        return share(new Buffer(allocate(room), false));
    }

    /** Returns a constant buffer of zeros. */
    static Buffer zeros(long bytes) {
        return new Buffer(allocate(bytes), true);
    }

    /**
     * Allocates zeroed memory. The garbage collector frees it after the last snapshot that reads
     * it.
     */
    private static MemorySegment allocate(long bytes) {
        return Arena.ofAuto().allocate(bytes, ALIGNMENT_BYTES);
    }

    /**
     * Records that one slot does not hold the buffer any more. A buffer that no slot holds can be
     * reused.
     */
    void release(Buffer buffer) {
        if (!buffer.constant && --buffer.slots == 0) {
            idle.add(buffer);
        }
    }
}
