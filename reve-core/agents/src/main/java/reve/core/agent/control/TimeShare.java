// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import java.util.function.LongSupplier;

/**
 * The account of work that may take at most a tenth of the elapsed time on average. Work may take
 * up to 50 ms in advance. Not thread-safe: the owner guards it by its lock.
 */
final class TimeShare {

    /** Divisor of the elapsed time, which gives the maximum time for the work. */
    private static final int SHARE = 10;

    /**
     * Time by which work may exceed its part of the elapsed time before further work must wait
     * [ns], multiplied by {@link #SHARE}.
     */
    private static final long ADVANCE_NANOS = 500_000_000;

    private final LongSupplier clock;

    /** Time at which the work so far will have used exactly its part of the elapsed time [ns]. */
    private long paidNanos;

    /**
     * @param clock returns the time since a fixed moment [ns], not negative
     */
    TimeShare(LongSupplier clock) {
        this.clock = clock;
    }

    /** Returns whether further work may begin. */
    boolean isOpen() {
        return paidNanos - clock.getAsLong() <= ADVANCE_NANOS;
    }

    /** Records work that ends now and took this time [ns]. */
    void pay(long nanos) {
        paidNanos = Math.max(paidNanos, clock.getAsLong()) + SHARE * nanos;
    }
}
