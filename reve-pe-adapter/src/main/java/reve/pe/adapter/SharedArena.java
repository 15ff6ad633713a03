// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import org.jspecify.annotations.Nullable;

import reve.core.world.ColumnArena;
import reve.pe.posix.SharedMemory;
import reve.pe.posix.SharedPart;

import java.lang.foreign.MemorySegment;
import java.util.Map;
import java.util.TreeMap;

/**
 * Column memory that another process can map: each column has its own file descriptor. For the
 * world's thread only.
 */
public final class SharedArena implements ColumnArena {
    private final TreeMap<Long, SharedMemory> byAddress = new TreeMap<>();

    @Override
    public MemorySegment reserve(String name, long bytes) {
        SharedMemory memory = new SharedMemory(name, bytes);
        byAddress.put(memory.segment().address(), memory);
        return memory.segment();
    }

    /**
     * Returns the file descriptor and offset with which another process can map a column, or a part
     * of it.
     *
     * @param memory from {@link #reserve}, or a part of it
     */
    public SharedPart part(MemorySegment memory) {
        Map.Entry<Long, SharedMemory> below = byAddress.floorEntry(memory.address());
        SharedMemory found = below == null ? null : below.getValue();
        long offset = below == null ? 0 : memory.address() - below.getKey();
        boolean contains =
                found != null && offset + memory.byteSize() <= found.segment().byteSize();
        return new SharedPart(find(memory, contains ? found : null).descriptor(), offset);
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
