// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.ArrayList;
import java.util.List;

/**
 * Forces that act on bodies for some frames, beside what laws work out. During PHYSICS they are
 * part of the column {@code appliedForce}, which otherwise holds what designers put there. World's
 * thread.
 */
public final class Forces {

    /** Most frames that a force acts for. */
    public static final long MAX_FRAMES = 1L << 53;

    private static final String COLUMN = "appliedForce";

    private final WorldGuard guard;
    private final FrameRecord record;
    private final Table bodies;
    private final Column column;
    private final List<Force> active = new ArrayList<>();
    private double[] before = {};
    private int framesPerSecond = 1;

    /**
     * @param guard asked before each change
     * @param record gets to know of each new force
     */
    Forces(Table bodies, WorldGuard guard, FrameRecord record) {
        this.bodies = bodies;
        this.guard = guard;
        this.record = record;
        this.column = bodies.column(COLUMN);
    }

    /** How fast the world's frames follow each other in its own time; said by who makes them. */
    void setFramesPerSecond(int newFramesPerSecond) {
        framesPerSecond = newFramesPerSecond;
    }

    /** The least number of frames, 1 to {@link #MAX_FRAMES}, that last for so long [s]. */
    public long frames(double seconds) {
        return Math.clamp((long) Math.ceil(seconds * framesPerSecond - 1e-9), 1, MAX_FRAMES);
    }

    /** Adds a force, from the next PHYSICS on. It ends early if the item goes. */
    public void add(Force force) {
        guard.requireEditable();
        active.add(force);
        record.note(new WorldChange.Pushed(force));
    }

    /** Forces that have not ended, in the order added: what an image of the world has to keep. */
    public List<Force> active() {
        return List.copyOf(active);
    }

    /** Replaces all forces, as a world is restored. */
    void restore(List<Force> forces) {
        active.clear();
        active.addAll(forces);
    }

    /** Before PHYSICS: adds the forces to the column, one after the other. */
    void apply() {
        if (before.length < 3 * active.size()) {
            before = new double[6 * active.size()];
        }
        for (int i = 0; i < active.size(); i++) {
            int row = row(active.get(i));
            for (int axis = 0; row >= 0 && axis < 3; axis++) {
                double present = column.getDouble(row, axis);
                before[3 * i + axis] = present;
                column.write(row, axis, present + active.get(i).newtons().get(axis));
            }
        }
    }

    /** After PHYSICS: puts the column back, to the bit, and ends what has acted long enough. */
    void withdraw() {
        if (active.isEmpty()) {
            return;
        }
        List<Force> remaining = new ArrayList<>();
        for (int i = active.size() - 1; i >= 0; i--) {
            Force force = active.get(i);
            int row = row(force);
            for (int axis = 0; row >= 0 && axis < 3; axis++) {
                column.write(row, axis, before[3 * i + axis]);
            }
            if (row >= 0 && force.frames() > 1) {
                remaining.add(new Force(force.item(), force.newtons(), force.frames() - 1));
            }
        }
        restore(remaining.reversed());
    }

    /** Where the item is, -1 if it has gone or become scenery. */
    private int row(Force force) {
        return bodies.hasPhysics(force.item()) ? bodies.rowOf(force.item()) : -1;
    }
}
