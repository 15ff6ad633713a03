// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.List;

/**
 * Everything a world is at the end of a frame: all columns, which item is in which row, what is
 * symbolic, its age, forces that have not ended, and the last id given out. A world that takes it
 * over with {@link World#restore} goes on with the same bits. Its memory is its own, so it may be
 * kept for as long as it is wanted, and filled again and again. One thread at a time.
 */
public final class WorldImage implements AutoCloseable {

    private static final long ALIGNMENT_BYTES = 64;

    private final Arena arena = Arena.ofShared();
    private final List<TableCopy> tables;
    private PMap<ItemId, ItemSymbols> symbols = TreePMap.empty();
    private List<Force> forces = List.of();
    private long frame;
    private long age;
    private long lastId;

    /** Room for a world of a prototype; nothing in it yet. World's thread. */
    public WorldImage(World world) {
        tables =
                world.tables().stream().map(table -> new TableCopy(table, this::allocate)).toList();
    }

    /** Copies a world of the same prototype. World's thread, between frames or in PUBLISH. */
    public void copyFrom(World world, long atFrame) {
        world.guard().checkOwner();
        for (int i = 0; i < tables.size(); i++) {
            tables.get(i).copyFrom(world.tables().get(i));
        }
        setSymbolic(atFrame, world.lastId(), world.symbols());
        setAge(world.age());
        setForces(world.forces().active());
    }

    /** What is no column; for whoever fills the tables from elsewhere. */
    public void setSymbolic(long atFrame, long lastItemId, PMap<ItemId, ItemSymbols> itemSymbols) {
        frame = atFrame;
        lastId = lastItemId;
        symbols = itemSymbols;
    }

    /** How old the world was; for whoever fills the tables from elsewhere. */
    public void setAge(long frames) {
        age = frames;
    }

    /** Forces that have not ended; for whoever fills the tables from elsewhere. */
    public void setForces(List<Force> active) {
        forces = List.copyOf(active);
    }

    /** Forces that have not ended, in the order in which they were added. */
    public List<Force> forces() {
        return forces;
    }

    /** The frame at whose end the world was like this. */
    public long frame() {
        return frame;
    }

    /** Frames of simulated time that the world had behind it. */
    public long age() {
        return age;
    }

    /** The highest id that was ever given to an item. */
    public long lastId() {
        return lastId;
    }

    /** What is symbolic about all items, in the order of their ids. */
    public PMap<ItemId, ItemSymbols> symbols() {
        return symbols;
    }

    /** In the order of {@link WorldPrototype#kinds()}. */
    public List<TableCopy> tables() {
        return tables;
    }

    /** Size of the columns [bytes]. */
    public long bytes() {
        return tables.stream().mapToLong(TableCopy::bytes).sum();
    }

    /** Frees the memory. May be called twice. */
    @Override
    public void close() {
        if (arena.scope().isAlive()) {
            arena.close();
        }
    }

    private MemorySegment allocate(long bytes) {
        return arena.allocate(bytes, ALIGNMENT_BYTES);
    }
}
