// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import java.util.List;
import java.util.concurrent.atomic.AtomicBoolean;

/**
 * A world as it was at the end of one frame, for one reading thread. It shares a slot of a {@link
 * SnapshotRing}: a reader that keeps it too long loses it, after which numbers read from it are
 * nonsense (never unsafe). So: read, then ask {@link #lost()}, then believe.
 */
public final class WorldSnapshot implements AutoCloseable {

    private final SnapshotSlot slot;
    private final long stamp;
    private final long frame;
    private final double timeSeconds;
    private final List<TableSnapshot> tables;
    private final PMap<ItemId, ItemSymbols> symbols;
    private final List<WorldEvent> events;
    private @Nullable Space space;
    private final AtomicBoolean closed = new AtomicBoolean();

    WorldSnapshot(
            SnapshotSlot slot,
            long stamp,
            long frame,
            double timeSeconds,
            List<TableSnapshot> tables,
            PMap<ItemId, ItemSymbols> symbols,
            List<WorldEvent> events) {
        this.slot = slot;
        this.stamp = stamp;
        this.frame = frame;
        this.timeSeconds = timeSeconds;
        this.tables = List.copyOf(tables);
        this.symbols = symbols;
        this.events = events;
    }

    /** The frame at whose end the world was like this. */
    public long frame() {
        return frame;
    }

    /** Simulated time at the end of the frame [s]. */
    public double timeSeconds() {
        return timeSeconds;
    }

    /**
     * @throws IllegalArgumentException if the prototype has no such kind
     * @throws IllegalStateException after {@link #close()}
     */
    public TableSnapshot table(String kind) {
        for (TableSnapshot table : tables()) {
            if (table.kind().equals(kind)) {
                return table;
            }
        }
        throw new IllegalArgumentException(
                "kind \""
                        + kind
                        + "\" does not exist; kinds are "
                        + tables.stream().map(TableSnapshot::kind).toList());
    }

    /** In the order of {@link WorldPrototype#kinds()}; throws after {@link #close()}. */
    public List<TableSnapshot> tables() {
        if (closed.get()) {
            throw new IllegalStateException("the snapshot of frame " + frame + " is closed");
        }
        return tables;
    }

    /**
     * Which bodies were where. The first call builds a tree of all boxes, in a millisecond per ten
     * thousand bodies or so; throws after {@link #close()}.
     */
    public Space space() {
        TableSnapshot bodies = table(WorldPrototype.BODY);
        if (space == null) {
            space =
                    new Space(
                            bodies.ids(),
                            bodies.column("boundsMin"),
                            bodies.column("boundsMax"),
                            () -> 0,
                            () -> 0,
                            id -> true);
        }
        return space;
    }

    /** How bodies were to each other; as {@link #space()}. */
    public Relations relations() {
        return new Relations(table(WorldPrototype.BODY), space(), id -> symbols.get(id).name());
    }

    /** What is symbolic about all items, in the order of their ids; valid for ever. */
    public PMap<ItemId, ItemSymbols> symbols() {
        return symbols;
    }

    /** What happened in the frame, in order; valid for ever. */
    public List<WorldEvent> events() {
        return events;
    }

    /** True if the slot was overwritten since: what was read from tables may be nonsense. */
    public boolean lost() {
        return slot.isOverwrittenSince(stamp);
    }

    /** Gives the slot back. */
    @Override
    public void close() {
        if (!closed.getAndSet(true)) {
            slot.release();
        }
    }
}
