// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

/**
 * Checks that the owner thread uses a world, and that a change is permitted now.
 *
 * <p>One thread owns a world: first the thread that created it, then the thread that last called
 * {@link #claim()}; {@code FrameLoop} calls it for the thread that runs it. With {@code
 * -Dreve.check.thread=true} every use by another thread is refused.
 */
public final class WorldGuard {

    private static final boolean CHECK_THREAD = Boolean.getBoolean("reve.check.thread");

    private final String world;
    private volatile Thread owner = Thread.currentThread();
    private @Nullable String lockedBy;
    private @Nullable String inspectedBy;

    /** Code that may read but not change the world. */
    public interface Inspection<T, E extends Exception> {
        /** Reads the world, and returns a result. */
        T look() throws E;
    }

    /**
     * @param world its name, for messages
     */
    WorldGuard(String world) {
        this.world = world;
    }

    /** Makes the calling thread the owner; the former owner must have stopped using the world. */
    public void claim() {
        owner = Thread.currentThread();
    }

    /** Refuses to add or remove items until {@link #unlockStructure()}; messages name the phase. */
    void lockStructure(String phase) {
        checkOwner();
        lockedBy = phase;
    }

    void unlockStructure() {
        checkOwner();
        lockedBy = null;
    }

    /**
     * Runs code that must not change the world. Until it returns, every change is refused with an
     * IllegalStateException that names {@code inspector}.
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
