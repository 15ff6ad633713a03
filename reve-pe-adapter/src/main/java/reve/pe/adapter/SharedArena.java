// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.world.ColumnArena;
import reve.pe.posix.SharedMemory;

import java.lang.foreign.MemorySegment;
import java.util.HashMap;
import java.util.Map;

/**
 * Column memory that another process can map: each column has its own file descriptor. Same thread
 * rule as the world's.
 */
public final class SharedArena implements ColumnArena {
    private final Map<Long, SharedMemory> byAddress = new HashMap<>();

    @Override
    public MemorySegment reserve(String name, long bytes) {
        SharedMemory memory = new SharedMemory(name, bytes);
        byAddress.put(memory.segment().address(), memory);
        return memory.segment();
    }

    /**
     * Returns the descriptor of a column, valid in this process.
     *
     * @param memory from {@link #reserve}, or a part of it with the same start
     */
    public int descriptor(MemorySegment memory) {
        return find(memory, byAddress.get(memory.address())).descriptor();
    }

    @Override
    public void release(MemorySegment memory) {
        find(memory, byAddress.remove(memory.address())).close();
    }

    @Override
    public void close() {
        byAddress.values().forEach(SharedMemory::close);
        byAddress.clear();
    }

    private static SharedMemory find(MemorySegment memory, @Nullable SharedMemory found) {
        if (found == null) {
            throw new IllegalArgumentException(
                    "memory at " + memory.address() + " was not reserved here");
        }
        return found;
    }
}
