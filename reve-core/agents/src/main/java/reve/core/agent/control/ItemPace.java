// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.world.ActionRefused;

import java.util.concurrent.locks.LockSupport;
import java.util.function.BooleanSupplier;
import java.util.function.LongSupplier;

/**
 * The pace at which control clients add, change or rewind the items of a world. All worlds of a
 * server share its thread for agents and its garbage collector, and new items are costly for both.
 * A command therefore waits after commands with many items. A world that has the server for itself
 * has no such limit. See docs/decisions/0363. For any thread.
 */
final class ItemPace {
    /** Number of items per second in the long run. */
    static final double PER_SECOND = 10_000;

    /**
     * Number of items by which commands may be ahead of this pace before the next one waits. A
     * command with more items, such as the rewind of a large world, counts as one with this number.
     */
    static final double AHEAD = 20_000;

    /** Longest wait; a command that would have to wait longer is refused [s]. */
    static final double LONGEST_SECONDS = 5;

    /** A wait of the calling thread. */
    interface Sleeper {
        /** Waits for a time [ns]. */
        void sleep(long nanos);
    }

    private final BooleanSupplier isShared;
    private final LongSupplier clock;
    private final Sleeper sleeper;

    /** Number of items that are ahead of the pace, at the time of the next field. */
    private double ahead;

    private long atNanos;

    /**
     * @param isShared returns whether the server has further worlds
     */
    ItemPace(BooleanSupplier isShared) {
        this(isShared, System::nanoTime, ItemPace::sleep);
    }

    /**
     * @param clock returns the time [ns]
     */
    ItemPace(BooleanSupplier isShared, LongSupplier clock, Sleeper sleeper) {
        this.isShared = isShared;
        this.clock = clock;
        this.sleeper = sleeper;
        this.atNanos = clock.getAsLong();
    }

    /**
     * Waits until a command may add, change or rewind this number of items.
     *
     * @throws ActionRefused if the wait would be too long
     */
    void take(int items) throws ActionRefused {
        if (items > 0 && isShared.getAsBoolean()) {
            double seconds = reserve(items);
            if (seconds > 0) {
                sleeper.sleep(Math.round(seconds * 1e9));
            }
        }
    }

    private static void sleep(long nanos) {
        long end = System.nanoTime() + nanos;
        long left = nanos;
        while (left > 0 && !Thread.currentThread().isInterrupted()) {
            LockSupport.parkNanos(left);
            left = end - System.nanoTime();
        }
    }

    /** Returns the time that the command has to wait [s]. */
    private synchronized double reserve(int items) throws ActionRefused {
        long now = clock.getAsLong();
        ahead = Math.max(0, ahead - (now - atNanos) * 1e-9 * PER_SECOND);
        atNanos = now;
        double wait = (ahead - AHEAD) / PER_SECOND;
        if (wait > LONGEST_SECONDS) {
            throw new ActionRefused(
                    "world-busy",
                    "control clients have just added, changed or rewound more than "
                            + Math.round(ahead)
                            + " items of this world; try again in "
                            + (long) Math.ceil(wait)
                            + " s");
        }
        ahead += Math.min(items, AHEAD);
        return wait;
    }
}
