// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.pcollections.PMap;
import org.pcollections.TreePMap;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.util.List;

/**
 * The complete state of a world at the end of a frame. It contains all columns, the item of each
 * row, symbolic data, age, remaining forces, and the last assigned id. A world that restores the
 * image with {@link World#restore} continues with the same bits.
 *
 * <p>The image owns its memory, so it can be kept for any time and overwritten with another state.
 * Only one thread may use it at a time.
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

    /** Creates an empty image for a world of the prototype. For the world's thread only. */
    public WorldImage(World world) {
        tables =
                world.tables().stream().map(table -> new TableCopy(table, this::allocate)).toList();
    }

    /**
     * Copies the state of a world of the same prototype. For the world's thread, between frames or
     * in the phase PUBLISH.
     */
    public void copyFrom(World world, long atFrame) {
        world.guard().checkOwner();
        for (int i = 0; i < tables.size(); i++) {
            tables.get(i).copyFrom(world.tables().get(i));
        }
        setSymbolic(atFrame, world.lastId(), world.symbols());
        setAge(world.age());
        setForces(world.forces().active());
    }

    /** Sets the symbolic data. This method is for decoders, which fill the tables themselves. */
    public void setSymbolic(long atFrame, long lastItemId, PMap<ItemId, ItemSymbols> itemSymbols) {
        frame = atFrame;
        lastId = lastItemId;
        symbols = itemSymbols;
    }

    /**
     * Sets the age of the world [frames]. This method is for decoders, which fill the tables
     * themselves.
     */
    public void setAge(long frames) {
        age = frames;
    }

    /**
     * Sets the forces that still act in later frames. This method is for decoders, which fill the
     * tables themselves.
     */
    public void setForces(List<Force> active) {
        forces = List.copyOf(active);
    }

    /** Returns the forces that still act in later frames, in the order of addition. */
    public List<Force> forces() {
        return forces;
    }

    /** Returns the number of the frame whose end the image shows. */
    public long frame() {
        return frame;
    }

    /** Returns the age of the world in the image [frames]. */
    public long age() {
        return age;
    }

    /** Returns the highest id that was ever assigned to an item. */
    public long lastId() {
        return lastId;
    }

    /** Returns the symbolic data of all items, in the order of their ids. */
    public PMap<ItemId, ItemSymbols> symbols() {
        return symbols;
    }

    /** Returns the tables in the order of {@link WorldPrototype#kinds()}. */
    public List<TableCopy> tables() {
        return tables;
    }

    /** Returns the size of the columns [bytes]. */
    public long bytes() {
        return tables.stream().mapToLong(TableCopy::bytes).sum();
    }

    /** Frees the memory. Idempotent. */
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
