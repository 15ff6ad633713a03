// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.Optional;

/**
 * The remaining time by which agents in lock-step may delay other agents. Agents with the same
 * token share one allowance; without tokens, all agents share one. The time for which other agents
 * wait is subtracted. A fraction of the elapsed time, {@value #REFILL}, is added. For the frame
 * loop's thread, except where stated.
 */
public final class Allowance {

    /** Time added to the allowance, as a fraction of elapsed time. */
    static final double REFILL = 0.1;

    /**
     * Fraction of the full allowance that an exhausted allowance must regain before its agents may
     * delay others again.
     */
    static final double RESTORED = 0.5;

    private static final double NO_LIMIT = 1e18;

    private final double fullNanos;
    private double leftNanos;
    private long countedNanos;

    /** True if the list of allowances that delay the current frame already contains this one. */
    private boolean noted;

    private volatile ByteBuffer home = ByteBuffer.allocate(0);
    private volatile long answeredNanos;
    private volatile boolean spent;

    /**
     * @param full the initial and largest value of the allowance; empty for no limit
     */
    Allowance(Optional<Duration> full, long nowNanos) {
        this.fullNanos = full.map(time -> (double) time.toNanos()).orElse(NO_LIMIT);
        this.leftNanos = fullNanos;
        this.countedNanos = nowNanos;
        this.answeredNanos = nowNanos;
    }

    // ---- methods for any thread ----

    /** Records that one of the agents is ready, or has left. */
    void answer(long nowNanos) {
        answeredNanos = nowNanos;
    }

    /** Returns whether the allowance is exhausted, so that its agents may not delay others. */
    public boolean isSpent() {
        return spent;
    }

    /** Records the network address of an agent. */
    void comeFrom(ByteBuffer address) {
        home = address;
    }

    /** Returns whether the agents of both allowances have the same network address. */
    boolean isNeighbourOf(Allowance other) {
        return this == other || home.equals(other.home);
    }

    // ---- methods for the frame loop's thread ----

    /**
     * Records that an agent is not ready.
     *
     * @return false if this is already recorded for the frame
     */
    boolean note() {
        boolean isNew = !noted;
        noted = true;
        return isNew;
    }

    void forgetNote() {
        noted = false;
    }

    /**
     * Returns the time when an agent of this allowance last became ready [ns]. A time outside the
     * interval is replaced by the nearer end of the interval.
     */
    long answeredBetween(long fromNanos, long toNanos) {
        long answered = answeredNanos;
        if (answered - fromNanos < 0) {
            return fromNanos;
        }
        return answered - toNanos < 0 ? answered : toNanos;
    }

    /**
     * Returns the maximum time that other agents wait in one frame for the agents of this allowance
     * [ns]. The result is at least {@code leastNanos}.
     */
    long left(long leastNanos) {
        return spent ? leastNanos : Math.max(leastNanos, (long) leftNanos);
    }

    /**
     * Charges the time that other agents have waited [ns].
     *
     * @return true if the allowance has become exhausted, or has been restored
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
