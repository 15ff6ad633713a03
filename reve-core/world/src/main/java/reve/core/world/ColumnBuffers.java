// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.ArrayList;
import java.util.List;

/**
 * The memory that the slots of a {@link SnapshotRing} keep copies of one column in. Slots of which
 * the column is the same to the byte share a copy. World's thread only.
 */
final class ColumnBuffers {

    private static final long ALIGNMENT_BYTES = 64;

    /** What grows gets room for an eighth more rows, so that it needs no new memory each frame. */
    private static final int SLACK = 8;

    /** A copy, and in how many slots it is; one that is constant is not counted. */
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

    /** What a slot holds that was not written yet. */
    static final Buffer NONE = new Buffer(MemorySegment.NULL, true);

    private final List<Buffer> idle = new ArrayList<>();
    private long largest;

    /** One more slot holds a buffer. */
    Buffer share(Buffer buffer) {
        buffer.slots++;
        return buffer;
    }

    /** A buffer that no slot holds, for one; smaller ones are forgotten. */
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

    /** Zeros that nobody ever writes to. */
    static Buffer zeros(long bytes) {
        return new Buffer(allocate(bytes), true);
    }

    /** Zeroed memory, collected with the last snapshot that reads it. */
    private static MemorySegment allocate(long bytes) {
        return Arena.ofAuto().allocate(bytes, ALIGNMENT_BYTES);
    }

    /** A slot lets a buffer go. */
    void release(Buffer buffer) {
        if (!buffer.constant && --buffer.slots == 0) {
            idle.add(buffer);
        }
    }
}
