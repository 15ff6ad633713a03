// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.ArrayList;
import java.util.List;

/**
 * Forces that actions exert on bodies for a number of frames. During the phase PHYSICS they are
 * added to the column {@code appliedForce}, from which laws read them. This column contains only
 * the values of the world's designer at other times. For the world's thread only.
 */
public final class Forces {

    /** Maximum duration of a force [frames]. */
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
     * @param guard called before each change
     * @param record receives each new force
     */
    Forces(Table bodies, WorldGuard guard, FrameRecord record) {
        this.bodies = bodies;
        this.guard = guard;
        this.record = record;
        this.column = bodies.column(COLUMN);
    }

    /** Sets the number of frames per second of world time. */
    void setFramesPerSecond(int newFramesPerSecond) {
        framesPerSecond = newFramesPerSecond;
    }

    /**
     * Returns the smallest number of frames that last at least {@code seconds} of world time [s],
     * limited to 1 to {@link #MAX_FRAMES}.
     */
    public long frames(double seconds) {
        return Math.clamp((long) Math.ceil(seconds * framesPerSecond - 1e-9), 1, MAX_FRAMES);
    }

    /**
     * Adds a force. It acts from the next PHYSICS phase on, and ends early if the item is removed.
     */
    public void add(Force force) {
        guard.requireEditable();
        active.add(force);
        record.note(new WorldChange.Pushed(force));
    }

    /**
     * Returns the forces that have not ended, in the order of addition. Images of the world store
     * them.
     */
    public List<Force> active() {
        return List.copyOf(active);
    }

    /** Replaces all forces by those of a restored image. */
    void restore(List<Force> forces) {
        active.clear();
        active.addAll(forces);
    }

    /**
     * Adds the forces to the column {@code appliedForce}, in the order of addition. Called before
     * the phase PHYSICS.
     */
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

    /**
     * Restores the bits that the column {@code appliedForce} had before {@link #apply}. Removes
     * forces that have ended. Called after the phase PHYSICS.
     */
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

    /**
     * Returns the row of the item. Returns -1 if the item was removed or is scenery, which has no
     * physics.
     */
    private int row(Force force) {
        return bodies.hasPhysics(force.item()) ? bodies.rowOf(force.item()) : -1;
    }
}
