// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.Optional;

/**
 * How long agents in lock-step may still keep others waiting. The agents of one token share an
 * allowance; without tokens all agents do. Waiting uses it up, and {@value #REFILL} of all time
 * comes back. The frame loop's thread, but where said otherwise.
 */
public final class Allowance {

    /** Part of the time that comes back. */
    static final double REFILL = 0.1;

    /** Part of the whole that must have come back before a spent allowance counts again. */
    static final double RESTORED = 0.5;

    private static final double NO_LIMIT = 1e18;

    private final double fullNanos;
    private double leftNanos;
    private long countedNanos;

    /** In this frame an agent was not ready yet. */
    private boolean noted;

    private volatile ByteBuffer home = ByteBuffer.allocate(0);
    private volatile long answeredNanos;
    private volatile boolean spent;

    /**
     * @param full the whole; without, there is no limit
     */
    Allowance(Optional<Duration> full, long nowNanos) {
        this.fullNanos = full.map(time -> (double) time.toNanos()).orElse(NO_LIMIT);
        this.leftNanos = fullNanos;
        this.countedNanos = nowNanos;
        this.answeredNanos = nowNanos;
    }

    // ---- any thread ----

    /** One of its agents is ready, or is no longer there. */
    void answer(long nowNanos) {
        answeredNanos = nowNanos;
    }

    /** Returns true if its agents may no longer keep others waiting. */
    public boolean isSpent() {
        return spent;
    }

    /** Its agent comes from that network address. */
    void comeFrom(ByteBuffer address) {
        home = address;
    }

    /** Whether their agents come from the same network address. */
    boolean isNeighbourOf(Allowance other) {
        return this == other || home.equals(other.home);
    }

    // ---- loop's thread ----

    /** Notes that an agent is not ready yet. @return false if that is noted already */
    boolean note() {
        boolean isNew = !noted;
        noted = true;
        return isNew;
    }

    void forgetNote() {
        noted = false;
    }

    /** When the last of its agents was ready, as far as that is between two times. */
    long answeredBetween(long fromNanos, long toNanos) {
        long answered = answeredNanos;
        if (answered - fromNanos < 0) {
            return fromNanos;
        }
        return answered - toNanos < 0 ? answered : toNanos;
    }

    /** The longest that others may wait in one frame [ns], at least that time. */
    long left(long leastNanos) {
        return spent ? leastNanos : Math.max(leastNanos, (long) leftNanos);
    }

    /**
     * Others have waited that long [ns] until now.
     *
     * @return true if the allowance is spent by that, or counts again
     */
    boolean charge(long waitedNanos, long nowNanos) {
        leftNanos = Math.min(fullNanos, leftNanos + REFILL * (nowNanos - countedNanos));
        leftNanos = fullNanos == NO_LIMIT ? NO_LIMIT : Math.max(0, leftNanos - waitedNanos);
        countedNanos = nowNanos;
        boolean before = spent;
        spent = before ? leftNanos < RESTORED * fullNanos : leftNanos == 0;
        return spent != before;
    }
}
