// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;
import org.pcollections.PMap;

import java.util.List;
import java.util.Map;
import java.util.concurrent.atomic.AtomicBoolean;

/**
 * The state of a world at the end of one frame, for one reading thread. It uses a slot of a {@link
 * SnapshotRing}. The world overwrites this slot if the reader keeps it too long. Values that are
 * read afterwards are invalid, but reading stays safe.
 *
 * <p>A reader therefore reads first and then calls {@link #lost()}. It uses the values only if the
 * result is false.
 */
public final class WorldSnapshot implements AutoCloseable {

    private final SnapshotSlot slot;
    private final long stamp;
    private final long frame;
    private final double timeSeconds;
    private final List<TableSnapshot> tables;
    private final PMap<ItemId, ItemSymbols> symbols;
    private final List<WorldEvent> events;
    private final Map<ItemId, Map<String, double[]>> readings;
    private @Nullable Space space;
    private final AtomicBoolean closed = new AtomicBoolean();

    WorldSnapshot(
            SnapshotSlot slot,
            long stamp,
            long frame,
            double timeSeconds,
            List<TableSnapshot> tables,
            PMap<ItemId, ItemSymbols> symbols,
            List<WorldEvent> events,
            Map<ItemId, Map<String, double[]>> readings) {
        this.slot = slot;
        this.stamp = stamp;
        this.frame = frame;
        this.timeSeconds = timeSeconds;
        this.tables = List.copyOf(tables);
        this.symbols = symbols;
        this.events = events;
        this.readings = readings;
    }

    /** Returns the frame of the snapshot. */
    public long frame() {
        return frame;
    }

    /** Returns the simulated time at the end of the frame [s]. */
    public double timeSeconds() {
        return timeSeconds;
    }

    /**
     * Returns the table of a kind.
     *
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

    /**
     * Returns the tables in the order of {@link WorldPrototype#kinds()}. Throws an exception after
     * {@link #close()}.
     */
    public List<TableSnapshot> tables() {
        if (closed.get()) {
            throw new IllegalStateException("the snapshot of frame " + frame + " is closed");
        }
        return tables;
    }

    /**
     * Returns the spatial search. The first call builds a tree of all boxes. Throws an exception
     * after {@link #close()}.
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

    /** Returns the relations between bodies. Builds the same tree as {@link #space()}. */
    public Relations relations() {
        return new Relations(table(WorldPrototype.BODY), space(), id -> symbols.get(id).name());
    }

    /**
     * Returns the symbolic data of all items, in the order of their ids. The map is valid even if
     * the snapshot is lost.
     */
    public PMap<ItemId, ItemSymbols> symbols() {
        return symbols;
    }

    /**
     * Returns the events of the frame, in order. The list is valid even if the snapshot is lost.
     */
    public List<WorldEvent> events() {
        return events;
    }

    /**
     * Returns the numbers that {@link SensorProvider}s have measured, by item and name of the
     * sensor: the components of all quantities of the sensor. Sensors whose measurement failed are
     * missing. The map is valid even if the snapshot is lost, and must not be changed.
     */
    public Map<ItemId, Map<String, double[]>> readings() {
        return readings;
    }

    /**
     * Returns whether the world has overwritten the slot, so that values read from tables may be
     * invalid.
     */
    public boolean lost() {
        return slot.isOverwrittenSince(stamp);
    }

    /** Releases the slot. */
    @Override
    public void close() {
        if (!closed.getAndSet(true)) {
            slot.release();
        }
    }
}
