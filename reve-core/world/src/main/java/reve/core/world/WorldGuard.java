// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

/**
 * Who may use a world, and what may be changed of it now.
 *
 * <p>One thread owns a world: at first the one that made it, then the one that last called {@link
 * #claim()}; {@code FrameLoop} claims for whoever runs it. With {@code -Dreve.check.thread=true}
 * every use by another thread is refused.
 */
public final class WorldGuard {

    private static final boolean CHECK_THREAD = Boolean.getBoolean("reve.check.thread");

    private final String world;
    private volatile Thread owner = Thread.currentThread();
    private @Nullable String lockedBy;
    private @Nullable String inspectedBy;

    /** What is done by somebody who changes nothing. */
    public interface Inspection<T, E extends Exception> {
        /** Looks, and returns what was found. */
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

    /**
     * Refuses structural changes until {@link #unlockStructure()}; the phase appears in messages.
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
     * Lets somebody look at the world and change nothing: until that is done, every change is
     * refused with an IllegalStateException that says who is looking.
     */
    public <T, E extends Exception> T inspect(String who, Inspection<T, E> inspection) throws E {
        checkOwner();
        String outer = inspectedBy;
        inspectedBy = who;
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

    /** Values may be changed. */
    void requireEditable() {
        checkOwner();
        if (inspectedBy != null) {
            throw new IllegalStateException(
                    inspectedBy + " may look at world " + world + ", but not change it");
        }
    }

    /** Items may come and go. @param what the caller is about to do, for the message */
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
