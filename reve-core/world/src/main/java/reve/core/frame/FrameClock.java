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
     * Blocks the calling thread for about this duration [ns]. May return earlier, and returns at
     * once when the thread is unparked.
     */
    void park(long nanoseconds);
}
