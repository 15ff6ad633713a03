// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.function.BooleanSupplier;

/**
 * Keeps a frame loop from beginning its next frame for a while. Called on the loop's thread between
 * frames, and must not block, but where said otherwise.
 */
public interface FrameGate {

    /** Holds nothing. */
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
     * Whether a frame may begin that is due.
     *
     * @param nowNanoseconds what the loop's clock shows
     * @return 0 or less if it may, else the time after which to ask again [ns], sooner if the loop
     *     is woken up ({@link FrameLoop#wake})
     */
    long nanosecondsToWait(long frame, long nowNanoseconds);

    /**
     * Lets the loop's thread wait, for about that long [ns] or until {@link #wake}. A gate that
     * opens by what this thread could do meanwhile may have it do that.
     *
     * @param disturbed true if the loop has something else to do; a gate that does not park the
     *     thread asks it before it waits
     * @param clock the loop's own
     */
    default void await(long nanoseconds, BooleanSupplier disturbed, FrameClock clock) {
        clock.park(nanoseconds);
    }

    /** Ends {@link #await}; the loop's thread is unparked, too. Any thread. */
    default void wake() {}

    /** The loop is paused: time that was waited until now counts no more. */
    void paused();

    /** The world has become that of another frame, see {@link FrameLoop#continueAfter}. */
    void continuesAfter(long frame);
}
