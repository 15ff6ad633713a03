// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.HashMap;
import java.util.Map;

/** Allocator of column memory outside the Java heap. No other process can map this memory. */
public final class OffHeapArena implements ColumnArena {

    private static final long PAGE_BYTES = 4096;

    private final Map<Long, Arena> arenaByAddress = new HashMap<>();

    @Override
    public MemorySegment reserve(String name, long bytes) {
        Arena arena = Arena.ofShared();
        try {
            MemorySegment memory = arena.allocate(bytes, PAGE_BYTES);
            arenaByAddress.put(memory.address(), arena);
            return memory;
        } catch (IllegalArgumentException | OutOfMemoryError e) {
            arena.close();
            throw new IllegalStateException(
                    "cannot reserve " + bytes + " bytes for column " + name, e);
        }
    }

    @Override
    public void release(MemorySegment memory) {
        Arena arena = arenaByAddress.remove(memory.address());
        if (arena == null) {
            throw new IllegalArgumentException(
                    "memory at " + memory.address() + " was not reserved here");
        }
        arena.close();
    }

    @Override
    public void close() {
        arenaByAddress.values().forEach(Arena::close);
        arenaByAddress.clear();
    }
}
