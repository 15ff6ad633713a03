// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

/**
 * Limit on how often clients of all worlds join: a burst, then {@value #PER_SECOND} per second.
 * Further clients wait, in the order in which their hellos arrived, because each join and leave
 * costs all other clients an event. For the event loop's thread only.
 */
final class Hellos {

    static final int PER_SECOND = 100;

    private static final long INTERVAL_NANOS = 1_000_000_000 / PER_SECOND;

    private final long burstNanos;

    /** Time at which the last hello is answered or was answered. */
    private long lastNanos;

    /**
     * @param burst size of the burst
     */
    Hellos(int burst, long nowNanos) {
        this.burstNanos = burst * INTERVAL_NANOS;
        this.lastNanos = nowNanos - burstNanos;
    }

    /**
     * Counts a hello.
     *
     * @return time from which it may be answered, see {@link System#nanoTime}; in the past if it
     *     need not wait
     */
    long arrive(long nowNanos) {
        if (nowNanos - lastNanos > burstNanos) {
            lastNanos = nowNanos - burstNanos;
        }
        lastNanos += INTERVAL_NANOS;
        return lastNanos;
    }
}
