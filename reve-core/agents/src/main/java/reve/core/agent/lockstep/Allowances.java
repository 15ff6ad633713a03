// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import org.jspecify.annotations.Nullable;

import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.function.Consumer;

/**
 * Limits on the time by which agents in lock-step delay other agents. Other agents are agents in
 * real time, and ready agents in lock-step from another network address. A frame may begin later
 * than the world's rate requires. This delay is charged to the {@link Allowance} of the agents that
 * cause it. An agent whose allowance is exhausted delays a frame by at most the duration of a
 * frame, so that the world keeps at least half its rate. For the frame loop's thread, except where
 * stated.
 */
public final class Allowances {

    private final long frameNanos;
    private final Optional<Duration> full;
    private final Consumer<Allowance> judged;
    private final AtomicInteger realTime = new AtomicInteger();

    /**
     * Allowances by token name; one entry for all agents without a token. Guarded by this object's
     * lock.
     */
    private final Map<Optional<String>, Allowance> all = new HashMap<>();

    /**
     * Allowances that delay the current frame: those of agents that were not ready when the frame
     * was due, and those that are exhausted.
     */
    private final List<Allowance> noted = new ArrayList<>();

    private boolean hasBegun;
    private long begunNanos;

    /** Time at which the frame should begin at the world's rate [ns]. */
    private long wantedNanos;

    private boolean othersWait;

    /**
     * @param frameNanos duration of a frame at the world's rate [ns]
     * @param full the full allowance; if empty, there is no limit
     * @param judged receives each allowance that has become exhausted or restored
     */
    public Allowances(long frameNanos, Optional<Duration> full, Consumer<Allowance> judged) {
        this.frameNanos = frameNanos;
        this.full = full;
        this.judged = judged;
    }

    // ---- methods for any thread ----

    /**
     * Returns the allowance for the agents of a token or, without tokens, of all agents. The
     * allowance persists after its agents have left.
     *
     * @param tokenName name of the agent's token, if the server uses tokens
     * @param home network address of the agent
     */
    public synchronized Allowance of(Optional<String> tokenName, ByteBuffer home, long nowNanos) {
        Allowance allowance =
                all.computeIfAbsent(tokenName, unknown -> new Allowance(full, nowNanos));
        allowance.comeFrom(home);
        return allowance;
    }

    /** Adds {@code agents} to the number of agents in real time. The argument may be negative. */
    public void addRealTime(int agents) {
        realTime.addAndGet(agents);
    }

    /** Returns the maximum delay that the agent may cause in a round [ns]. */
    public long longestWaitNanos(Turn turn) {
        return turn.allowance().isSpent()
                ? Math.min(turn.deadlineNanos(), frameNanos)
                : turn.deadlineNanos();
    }

    // ---- methods for the frame loop's thread ----

    /** Records the time at which the frame could begin if no agent delayed it. */
    void due(long nowNanos) {
        long early = hasBegun ? begunNanos + frameNanos - nowNanos : 0;
        wantedNanos = nowNanos + Math.max(0, early);
    }

    /**
     * Postpones the planned start of the frame by a pause in which the server itself did not run
     * [ns].
     */
    void postpone(long pauseNanos) {
        wantedNanos += pauseNanos;
    }

    /** Determines whether agents can delay others in this frame. */
    void look(Turn[] turns) {
        othersWait = realTime.get() > 0 || haveSeveralHomes(turns);
    }

    /**
     * Returns whether the world may wait again for an agent that was away. The result is false if
     * the agent's allowance is exhausted and the agent would delay other agents.
     */
    boolean mayReturn(Turn turn, Turn[] turns) {
        return !turn.allowance().isSpent()
                || realTime.get() == 0 && !hasStranger(turn.allowance(), turns);
    }

    private static boolean hasStranger(Allowance allowance, Turn[] turns) {
        for (Turn turn : turns) {
            if (turn.isHere() && !turn.allowance().isNeighbourOf(allowance)) {
                return true;
            }
        }
        return false;
    }

    private static boolean haveSeveralHomes(Turn[] turns) {
        Turn first = null;
        for (Turn turn : turns) {
            if (turn.isHere()) {
                if (first != null && !turn.allowance().isNeighbourOf(first.allowance())) {
                    return true;
                }
                first = turn;
            }
        }
        return false;
    }

    /** Records that an agent is not ready, or that its allowance is exhausted. */
    void note(Turn turn, long nowNanos) {
        Allowance allowance = turn.allowance();
        if (allowance.note()) {
            noted.add(allowance);
            charge(allowance, 0, nowNanos);
        }
    }

    /**
     * Returns the remaining time that other agents wait for an agent [ns]. The result is negative
     * if the time is over.
     */
    long nanosecondsLeft(Turn turn, long nowNanos) {
        return othersWait
                ? wantedNanos - nowNanos + turn.allowance().left(frameNanos)
                : Long.MAX_VALUE;
    }

    /** Charges the time that other agents have waited. Called when the frame begins. */
    void begin(Turn[] turns, long nowNanos) {
        hasBegun = true;
        begunNanos = nowNanos;
        if (noted.isEmpty()) {
            return;
        }
        Turn first = othersWait ? firstReady(turns, null, nowNanos) : null;
        Turn next = first == null ? null : firstReady(turns, first, nowNanos);
        for (Allowance allowance : noted) {
            Turn other = first != null && allowance.isNeighbourOf(first.allowance()) ? next : first;
            long from = nowNanos;
            if (realTime.get() > 0) {
                from = wantedNanos;
            } else if (other != null) {
                from = other.allowance().answeredBetween(wantedNanos, nowNanos);
            }
            long until = allowance.answeredBetween(wantedNanos, nowNanos);
            charge(allowance, Math.max(0, until - from), nowNanos);
        }
        forget();
    }

    /**
     * Returns the agent that was ready first. Considers only agents whose network address differs
     * from that of {@code another}, unless this is null.
     */
    private @Nullable Turn firstReady(Turn[] turns, @Nullable Turn another, long nowNanos) {
        Turn first = null;
        long firstNanos = 0;
        for (Turn turn : turns) {
            if (turn.isHere()
                    && (another == null || !turn.allowance().isNeighbourOf(another.allowance()))) {
                long ready = turn.allowance().answeredBetween(wantedNanos, nowNanos);
                if (first == null || ready - firstNanos < 0) {
                    first = turn;
                    firstNanos = ready;
                }
            }
        }
        return first;
    }

    private void charge(Allowance allowance, long waitedNanos, long nowNanos) {
        if (allowance.charge(waitedNanos, nowNanos)) {
            judged.accept(allowance);
        }
    }

    /** Discards the waiting time of this frame. No allowance is charged for it. */
    void forget() {
        for (Allowance allowance : noted) {
            allowance.forgetNote();
        }
        noted.clear();
    }
}
