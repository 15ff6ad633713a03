// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.function.BooleanSupplier;

/**
 * A condition that a frame loop checks before each frame. The loop's thread calls the methods
 * between frames. They must not block, unless their comment permits it.
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
     * Decides whether a frame that is due may begin.
     *
     * @param nowNanoseconds time of the loop's clock [ns]
     * @return 0 or less if the frame may begin, otherwise the time after which the loop asks again
     *     [ns]. {@link FrameLoop#wake} makes the loop ask earlier
     */
    long nanosecondsToWait(long frame, long nowNanoseconds);

    /**
     * Blocks the loop's thread for about this duration [ns] or until {@link #wake}. Meanwhile the
     * gate may run work on this thread, for example read the messages that it waits for.
     *
     * @param disturbed returns true if the loop has other work. A gate that overrides this method
     *     must check this condition before it waits
     * @param clock the loop's clock
     */
    default void await(long nanoseconds, BooleanSupplier disturbed, FrameClock clock) {
        clock.park(nanoseconds);
    }

    /** Ends {@link #await}. The caller also unparks the loop's thread. For any thread. */
    default void wake() {}

    /**
     * Notifies the gate that the loop is paused. The time limits of the gate start again after the
     * pause.
     */
    void paused();

    /**
     * Notifies the gate that the world now has the state of another frame, see {@link
     * FrameLoop#continueAfter}.
     */
    void continuesAfter(long frame);
}
