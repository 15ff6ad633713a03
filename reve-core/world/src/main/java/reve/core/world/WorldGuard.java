// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

/**
 * Checks that only the owner thread uses a world, and that a change is permitted now.
 *
 * <p>The owner is the thread that last called {@link #claim()}, or else the thread that created the
 * world. {@code FrameLoop} calls that method for the thread that runs the loop. The option {@code
 * -Dreve.check.thread=true} makes the world refuse every use by another thread.
 */
public final class WorldGuard {

    private static final boolean CHECK_THREAD = Boolean.getBoolean("reve.check.thread");

    private final String world;
    private volatile Thread owner = Thread.currentThread();
    private @Nullable String lockedBy;
    private @Nullable String inspectedBy;

    /** A function that may read the world but must not change it. */
    public interface Inspection<T, E extends Exception> {
        /** Reads the world, and returns a result. */
        T look() throws E;
    }

    /**
     * @param world name of the world, for messages
     */
    WorldGuard(String world) {
        this.world = world;
    }

    /** Makes the calling thread the owner. The former owner must have stopped using the world. */
    public void claim() {
        owner = Thread.currentThread();
    }

    /**
     * Refuses to add or remove items until {@link #unlockStructure()}. Messages of refusals name
     * the phase.
     */
    void lockStructure(String phase) {
        checkOwner();
        lockedBy = phase;
    }

    void unlockStructure() {
        checkOwner();
        lockedBy = null;
    }

    /**
     * Runs code that must not change the world. Every change that this code attempts is refused
     * with an IllegalStateException that names {@code inspector}.
     */
    public <T, E extends Exception> T inspect(String inspector, Inspection<T, E> inspection)
            throws E {
        checkOwner();
        String outer = inspectedBy;
        inspectedBy = inspector;
        try {
            return inspection.look();
        } finally {
            inspectedBy = outer;
        }
    }

    void checkOwner() {
        if (CHECK_THREAD && Thread.currentThread() != owner) {
            throw new IllegalStateException(
                    "world "
                            + world
                            + " belongs to thread "
                            + owner.getName()
                            + ", but "
                            + Thread.currentThread().getName()
                            + " used it: read a snapshot, or claim() it when the owner has"
                            + " stopped");
        }
    }

    /** Requires that values may be changed now. */
    void requireEditable() {
        checkOwner();
        if (inspectedBy != null) {
            throw new IllegalStateException(
                    inspectedBy + " may look at world " + world + ", but not change it");
        }
    }

    /**
     * Requires that items may be added and removed now.
     *
     * @param what the intended change, for the message
     */
    void requireUnlocked(String what) {
        requireEditable();
        if (lockedBy != null) {
            throw new IllegalStateException(
                    "cannot "
                            + what
                            + " of world "
                            + world
                            + " in phase "
                            + lockedBy
                            + ": the structure changes in INTAKE, ACT or between frames only");
        }
    }
}
