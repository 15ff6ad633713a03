// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.lang.invoke.VarHandle;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicLong;

/**
 * Memory for one snapshot, guarded by a stamp (a sequence lock). The stamp is odd while the world's
 * thread writes, and even at all other times. Every write gives it another value.
 */
final class SnapshotSlot {

    /** Memory that the slots of one ring share. */
    static final class Memory {
        private final List<List<ColumnBuffers>> columns;
        private final Zeros zeros = new Zeros();

        Memory(World world) {
            columns =
                    world.tables().stream()
                            .map(
                                    table ->
                                            table.allColumns().stream()
                                                    .map(column -> new ColumnBuffers())
                                                    .toList())
                            .toList();
        }
    }

    private final List<SlotTable> tables = new ArrayList<>();
    private final AtomicInteger readers = new AtomicInteger();
    private final AtomicLong stamp = new AtomicLong();
    private long frame;
    private double timeSeconds;
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();
    private List<WorldEvent> events = List.of();
    private Map<ItemId, Map<String, double[]>> readings = Map.of();

    /**
     * @param memory memory that all slots of the ring share
     */
    SnapshotSlot(World world, Memory memory) {
        for (int i = 0; i < memory.columns.size(); i++) {
            tables.add(new SlotTable(world.tables().get(i), memory.columns.get(i), memory.zeros));
        }
    }

    boolean isFree() {
        return readers.get() == 0;
    }

    /**
     * Overwrites the slot, even if it has readers. Readers cannot acquire the slot after an
     * exception until it is written again. For the world's thread only.
     *
     * @param before the slot of the previous frame, with which the new frame shares unchanged
     *     columns
     */
    void write(World world, long newFrame, double newTimeSeconds, @Nullable SnapshotSlot before) {
        long writing = stamp.getPlain() | 1;
        stamp.setRelease(writing);
        VarHandle.storeStoreFence();
        frame = newFrame;
        timeSeconds = newTimeSeconds;
        symbols = world.symbols();
        events = world.events();
        readings = world.readings();
        for (int i = 0; i < tables.size(); i++) {
            tables.get(i)
                    .copyFrom(world.tables().get(i), before == null ? null : before.tables.get(i));
        }
        stamp.setRelease(writing + 1);
    }

    /** Returns a view of the slot, unless its content is incomplete. For any thread. */
    Optional<WorldSnapshot> acquire() {
        readers.incrementAndGet();
        long before = stamp.getAcquire();
        var views = new ArrayList<TableSnapshot>(tables.size());
        for (SlotTable table : tables) {
            views.add(table.view());
        }
        var snapshot =
                new WorldSnapshot(
                        this, before, frame, timeSeconds, views, symbols, events, readings);
        if (before % 2 == 1 || snapshot.lost()) {
            snapshot.close();
            return Optional.empty();
        }
        return Optional.of(snapshot);
    }

    boolean isOverwrittenSince(long earlierStamp) {
        VarHandle.loadLoadFence();
        return stamp.getAcquire() != earlierStamp;
    }

    void release() {
        readers.decrementAndGet();
    }
}
