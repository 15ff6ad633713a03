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
 * Bounds how long agents in lock-step keep others waiting. Others are agents in real time, and
 * agents in lock-step that come from another network address and are ready. An {@link Allowance} is
 * charged with the time by which a frame is later than the world's rate asks for. An agent without
 * allowance delays a frame by no more than a frame lasts, so that the world has half its rate. The
 * frame loop's thread, but where said otherwise.
 */
public final class Allowances {

    private final long frameNanos;
    private final Optional<Duration> full;
    private final Consumer<Allowance> judged;
    private final AtomicInteger realTime = new AtomicInteger();

    /** By token; of all agents without one. Guarded by this. */
    private final Map<Optional<String>, Allowance> all = new HashMap<>();

    /** Of agents that were not ready when the frame was due, and those that are spent. */
    private final List<Allowance> noted = new ArrayList<>();

    private boolean hasBegun;
    private long begunNanos;

    /** When the frame has to begin at the world's rate. */
    private long wantedNanos;

    private boolean othersWait;

    /**
     * @param frameNanos how long a frame lasts at the world's rate [ns]
     * @param full the whole of an allowance; without, there is no limit
     * @param judged takes each allowance that is spent now, or no longer
     */
    public Allowances(long frameNanos, Optional<Duration> full, Consumer<Allowance> judged) {
        this.frameNanos = frameNanos;
        this.full = full;
        this.judged = judged;
    }

    // ---- any thread ----

    /**
     * The allowance of a token's agent or, without tokens, that of all agents. It stays when its
     * agents leave.
     *
     * @param tokenName name of the agent's token, if the server takes tokens
     * @param home network address that the agent comes from
     */
    public synchronized Allowance of(Optional<String> tokenName, ByteBuffer home, long nowNanos) {
        Allowance allowance =
                all.computeIfAbsent(tokenName, unknown -> new Allowance(full, nowNanos));
        allowance.comeFrom(home);
        return allowance;
    }

    /** Agents in real time have come, or gone if that is negative. */
    public void addRealTime(int agents) {
        realTime.addAndGet(agents);
    }

    /** The longest that the agent may keep others waiting in a round [ns]. */
    public long longestWaitNanos(Turn turn) {
        return turn.allowance().isSpent()
                ? Math.min(turn.deadlineNanos(), frameNanos)
                : turn.deadlineNanos();
    }

    // ---- loop's thread ----

    /** From now on a frame could begin. */
    void due(long nowNanos) {
        long early = hasBegun ? begunNanos + frameNanos - nowNanos : 0;
        wantedNanos = nowNanos + Math.max(0, early);
    }

    /** Notes whether any other agent can be kept waiting in this frame. */
    void look(Turn[] turns) {
        othersWait = realTime.get() > 0 || haveSeveralHomes(turns);
    }

    /** Returns false if others wait that the agent has no allowance to delay. */
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

    /** Records that an agent is not ready, or that its allowance is spent. */
    void note(Turn turn, long nowNanos) {
        Allowance allowance = turn.allowance();
        if (allowance.note()) {
            noted.add(allowance);
            charge(allowance, 0, nowNanos);
        }
    }

    /** How long others still wait for an agent [ns], if they do; negative if no longer. */
    long nanosecondsLeft(Turn turn, long nowNanos) {
        return othersWait
                ? wantedNanos - nowNanos + turn.allowance().left(frameNanos)
                : Long.MAX_VALUE;
    }

    /** Charges the time that others waited; the frame begins now. */
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

    /** The agent that was ready first of those that are not neighbours of another one. */
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

    /** Discards the waiting time of this frame, which is not charged. */
    void forget() {
        for (Allowance allowance : noted) {
            allowance.forgetNote();
        }
        noted.clear();
    }
}
