// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.concurrent.locks.LockSupport;

/** The only clock a frame loop sees; it decides when frames run, never what is in them. */
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

    /** Monotonic time from an arbitrary origin [ns]. */
    long nanoTime();

    /** Waits about that long [ns]; may return early, and does when the thread is unparked. */
    void park(long nanoseconds);
}
