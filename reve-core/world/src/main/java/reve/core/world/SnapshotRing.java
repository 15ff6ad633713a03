// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;

/**
 * A fixed number of slots with the last published frames of a world, for any number of readers.
 * Neither the world nor a reader ever waits. A frame is written to the oldest slot without readers.
 * If all slots have readers, the frame is written to the oldest slot, and the readers of this slot
 * lose their snapshot.
 *
 * <p>A slot allocates memory when it is first needed. Slots share columns that did not change from
 * frame to frame.
 */
public final class SnapshotRing {

    private final World world;

    /** All slots except the latest, oldest first. */
    private final List<SnapshotSlot> older;

    private final SnapshotSlot.Memory memory;
    private final int slots;
    private int used;
    private volatile @Nullable SnapshotSlot latest;

    /**
     * @param slots maximum number of slots, at least 2, so that one can be read while another is
     *     written
     */
    public SnapshotRing(World world, int slots) {
        if (slots < 2) {
            throw new IllegalArgumentException(
                    "snapshot ring of " + slots + " slots, expected 2 or more");
        }
        this.world = world;
        this.slots = slots;
        this.older = new ArrayList<>(slots);
        this.memory = new SnapshotSlot.Memory(world);
    }

    /** Returns the prototype of the world. For any thread. */
    public WorldPrototype prototype() {
        return world.prototype();
    }

    /**
     * Copies the present world as one frame. Allocates memory only if the world has grown or has
     * events. For the world's thread, in the phase PUBLISH.
     *
     * @param frame number of the frame
     * @param timeSeconds simulated time at the end of the frame [s]
     */
    public void publish(long frame, double timeSeconds) {
        SnapshotSlot slot = oldestFreeSlot();
        SnapshotSlot previous = latest;
        slot.write(world, frame, timeSeconds, previous);
        older.remove(slot);
        latest = slot;
        if (previous != null) {
            older.add(previous);
        }
    }

    /**
     * Returns the last published frame; empty before the first one. Never waits. The reader must
     * close the snapshot soon, and check {@link WorldSnapshot#lost()} after reading. For any
     * thread.
     */
    public Optional<WorldSnapshot> acquireLatest() {
        while (true) {
            SnapshotSlot slot = latest;
            if (slot == null) {
                return Optional.empty();
            }
            Optional<WorldSnapshot> snapshot = slot.acquire();
            if (snapshot.isPresent()) {
                return snapshot;
            }
        }
    }

    /**
     * Returns a slot to write. Creates a slot unless the maximum number is reached. Otherwise takes
     * the oldest slot without readers, or the oldest slot if all have readers.
     */
    private SnapshotSlot oldestFreeSlot() {
        for (int i = 0; i < older.size(); i++) {
            if (older.get(i).isFree()) {
                return older.get(i);
            }
        }
        if (used < slots) {
            used++;
            older.add(new SnapshotSlot(world, memory));
            return older.getLast();
        }
        return older.getFirst();
    }
}
