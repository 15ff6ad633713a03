// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

/**
 * Limit on how often clients of all worlds join, because each join and leave costs all other
 * clients an event. A burst of clients may join at once. After the burst, {@value #PER_SECOND}
 * clients per second may join. For the event loop's thread only.
 */
final class Hellos {

    static final int PER_SECOND = 100;

    private final int burst;
    private double left;
    private long countedNanos;

    /**
     * @param burst size of the burst
     */
    Hellos(int burst, long nowNanos) {
        this.burst = burst;
        this.left = burst;
        this.countedNanos = nowNanos;
    }

    /** Returns whether another client may join now. */
    boolean haveLeft(long nowNanos) {
        left = Math.min(burst, left + (nowNanos - countedNanos) * PER_SECOND / 1e9);
        countedNanos = nowNanos;
        return left >= 1;
    }

    /** Counts a client that joins. The caller has checked {@link #haveLeft}. */
    void count() {
        left--;
    }
}
