// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import java.util.OptionalDouble;

/**
 * The round-trip time of a connection: the time from a ping of the server until the client's pong.
 * At most one measurement runs at a time. For any thread.
 */
final class RoundTrip {

    /** Minimum time between the end of a measurement and the next one [ns]. */
    private static final long INTERVAL_NANOS = 1_000_000_000;

    private final long patienceNanos;

    // Guarded by this object's lock.
    private boolean isMeasuring;
    private boolean isKnown;
    private long pingNanos;
    private long pongNanos;
    private long nanos;

    /**
     * @param patienceNanos time after which a new ping replaces one without a pong [ns]
     */
    RoundTrip(long patienceNanos) {
        this.patienceNanos = patienceNanos;
    }

    /**
     * Begins a measurement if none runs and the last one is old enough.
     *
     * @param nowNanos time at which the caller sends the ping [ns]
     * @return true if the caller must send a ping
     */
    synchronized boolean begin(long nowNanos) {
        boolean mayBegin =
                isMeasuring
                        ? nowNanos - pingNanos >= patienceNanos
                        : !isKnown || nowNanos - pongNanos >= INTERVAL_NANOS;
        if (mayBegin) {
            isMeasuring = true;
            pingNanos = nowNanos;
        }
        return mayBegin;
    }

    /** Ends the measurement, if one runs. */
    synchronized void end(long nowNanos) {
        if (isMeasuring) {
            isMeasuring = false;
            isKnown = true;
            pongNanos = nowNanos;
            nanos = nowNanos - pingNanos;
        }
    }

    /** Returns the time of the last measurement [s]; empty if no pong has arrived yet. */
    synchronized OptionalDouble seconds() {
        return isKnown ? OptionalDouble.of(nanos / 1e9) : OptionalDouble.empty();
    }
}
