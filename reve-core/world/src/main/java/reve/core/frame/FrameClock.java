// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.concurrent.locks.LockSupport;

/** The only clock of a frame loop. It determines when frames run, never their content. */
public interface FrameClock {

    /** The machine's monotonic clock. */
    FrameClock SYSTEM =
            new FrameClock() {
                @Override
                public long nanoTime() {
                    return System.nanoTime();
                }

                @Override
                public void park(long nanoseconds) {
                    LockSupport.parkNanos(nanoseconds);
                }
            };

    /** Returns monotonic time from an arbitrary origin [ns]. */
    long nanoTime();

    /**
     * Waits for about that long [ns]. May return early; returns at once when the thread is
     * unparked.
     */
    void park(long nanoseconds);
}
