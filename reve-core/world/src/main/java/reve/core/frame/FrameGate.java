// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.function.BooleanSupplier;

/**
 * A condition that a frame loop checks before each frame. Called on the loop's thread between
 * frames; must not block, unless a method says otherwise.
 */
public interface FrameGate {

    /** A gate that is always open. */
    FrameGate OPEN =
            new FrameGate() {
                @Override
                public long nanosecondsToWait(long frame, long nowNanoseconds) {
                    return 0;
                }

                @Override
                public void paused() {}

                @Override
                public void continuesAfter(long frame) {}
            };

    /**
     * Returns whether a due frame may begin.
     *
     * @param nowNanoseconds time of the loop's clock [ns]
     * @return 0 or less if it may begin, otherwise the time after which to ask again [ns]; the loop
     *     asks earlier if it is woken ({@link FrameLoop#wake})
     */
    long nanosecondsToWait(long frame, long nowNanoseconds);

    /**
     * Blocks the loop's thread for about that long [ns] or until {@link #wake}. The gate may
     * meanwhile do work on this thread that could open it.
     *
     * @param disturbed returns true if the loop has other work; a gate that does not park the
     *     thread checks it before it waits
     * @param clock the loop's clock
     */
    default void await(long nanoseconds, BooleanSupplier disturbed, FrameClock clock) {
        clock.park(nanoseconds);
    }

    /** Ends {@link #await}; the loop's thread is also unparked. Any thread. */
    default void wake() {}

    /** Notifies the gate that the loop is paused: the waiting time so far no longer counts. */
    void paused();

    /**
     * Notifies the gate that the world was replaced by that of another frame, see {@link
     * FrameLoop#continueAfter}.
     */
    void continuesAfter(long frame);
}
