package reve.core.world;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.invoke.VarHandle;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicLong;
import org.pcollections.PMap;
import org.pcollections.TreePMap;

/**
 * Room for one snapshot, guarded by a stamp (a sequence lock): odd from when the world's thread
 * begins to write until a whole frame is there, else even and different after every write.
 */
final class SnapshotSlot {

    private static final long ALIGNMENT_BYTES = 64;

    private final List<TableCopy> tables;
    private final AtomicInteger readers = new AtomicInteger();
    private final AtomicLong stamp = new AtomicLong();
    private long frame;
    private double timeSeconds;
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();
    private List<WorldEvent> events = List.of();

    SnapshotSlot(World world) {
        tables = world.tables().stream()
                .map(table -> new TableCopy(table, SnapshotSlot::allocate)).toList();
    }

    boolean isFree() {
        return readers.get() == 0;
    }

    /**
     * Overwrites the slot, readers or not. World's thread. If it throws, nobody can acquire the
     * slot until it is written again.
     */
    void write(World world, long newFrame, double newTimeSeconds) {
        long writing = stamp.getPlain() | 1;
        stamp.setRelease(writing);
        VarHandle.storeStoreFence();
        frame = newFrame;
        timeSeconds = newTimeSeconds;
        symbols = world.symbols();
        events = world.events();
        for (int i = 0; i < tables.size(); i++) {
            tables.get(i).copyFrom(world.tables().get(i));
        }
        stamp.setRelease(writing + 1);
    }

    /** A view of what the slot holds, unless that is no whole frame. Any thread. */
    Optional<WorldSnapshot> acquire() {
        readers.incrementAndGet();
        long before = stamp.getAcquire();
        var views = new ArrayList<TableSnapshot>(tables.size());
        for (TableCopy table : tables) {
            views.add(table.view());
        }
        var snapshot =
                new WorldSnapshot(this, before, frame, timeSeconds, views, symbols, events);
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

    /** Collected with the last snapshot that reads it: a reader may still hold the old one. */
    private static MemorySegment allocate(long bytes) {
        return Arena.ofAuto().allocate(bytes, ALIGNMENT_BYTES);
    }
}
