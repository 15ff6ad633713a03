// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.protocol.ClientMessage;

import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.AtomicReference;

/**
 * The rounds of one agent in lock-step. A round begins with every Nth frame. The first round begins
 * with the frame in which the agent joined. The agent receives a perception of this frame, and the
 * world does not begin the next round before the agent is ready.
 */
public final class Turn {

    private enum Presence {
        /** State in which the world waits for the agent. */
        HERE,
        /**
         * The agent missed too many deadlines in a row. The world does not wait for it until it
         * becomes ready again.
         */
        AWAY,
        /**
         * The connection is broken. The world does not wait for the agent until it has a new
         * connection.
         */
        BROKEN,
        /** The agent is back: its rounds restart with the next frame. */
        RETURNING,
        /** State after the agent has left the world. */
        GONE
    }

    /** Number of missed rounds in a row after which the world stops waiting for an agent. */
    static final int MAX_LATE_ROUNDS = 3;

    private final String agent;
    private final ClientMessage.LockStep wanted;
    private final long deadlineNanos;
    private final Allowance allowance;

    /** Number of rounds that the agent has finished or missed. */
    private final AtomicLong done = new AtomicLong();

    /** Number of ready messages received, including those that end no round. */
    private final AtomicLong readyMessages = new AtomicLong();

    private final AtomicReference<Presence> presence = new AtomicReference<>(Presence.HERE);

    /** True if the agent has been ready at least once. */
    private volatile boolean playing;

    /** Frame of the first round. Set on the loop's thread. */
    private volatile long origin = Long.MAX_VALUE;

    /**
     * The frame for which the world has stopped waiting for the agent. Set on the loop's thread.
     */
    private volatile long givenUp = -1;

    // Only the thread of the frame loop uses the fields below.
    private long missed;
    private boolean missedUnawaited;
    private int lateInRow;

    /**
     * Number of rounds that {@link #miss} has counted as finished or missed. The next field is the
     * value of {@link #readyMessages} at that time.
     */
    private long judged;

    private long messagesWhenJudged;

    /** True if an event has informed other agents that this agent is away. */
    private boolean away;

    /**
     * @param deadlineNanos maximum wait for the agent [ns]
     * @param allowance the allowance to which delays by the agent are charged
     */
    public Turn(
            String agent, ClientMessage.LockStep wanted, long deadlineNanos, Allowance allowance) {
        this.agent = agent;
        this.wanted = wanted;
        this.deadlineNanos = deadlineNanos;
        this.allowance = allowance;
    }

    /** Returns the lock-step settings that the agent requested in its hello. */
    public ClientMessage.LockStep wanted() {
        return wanted;
    }

    /** Returns the maximum wait for the agent [ns]. */
    public long deadlineNanos() {
        return deadlineNanos;
    }

    /** Returns the allowance to which delays by the agent are charged. */
    public Allowance allowance() {
        return allowance;
    }

    /** Ends the oldest round that the agent has not finished. */
    public void ready(long nowNanos) {
        playing = true;
        allowance.answer(
                nowNanos); // before the count changes, because the loop reads both in this order
        done.incrementAndGet();
        speak();
    }

    /**
     * Ends all rounds up to the round of {@code frame}, because the agent has processed the
     * perception of this frame. Has no effect if these rounds ended earlier or the frame is not
     * published yet.
     */
    public void ready(long frame, long published, long nowNanos) {
        playing = true;
        if (frame <= published && done.get() < rounds(frame)) {
            allowance.answer(nowNanos);
            done.accumulateAndGet(rounds(frame), Math::max);
        }
        speak();
    }

    private void speak() {
        readyMessages.incrementAndGet();
        presence.compareAndSet(Presence.AWAY, Presence.RETURNING);
    }

    /**
     * Records that the connection broke. The world does not wait for the agent until it has a new
     * connection.
     */
    public void breakOff(long nowNanos) {
        allowance.answer(nowNanos);
        presence.set(Presence.BROKEN);
    }

    /** Records a new connection: rounds restart with the next frame. */
    public void comeBack() {
        presence.set(Presence.RETURNING);
    }

    void leave(long nowNanos) {
        allowance.answer(nowNanos);
        presence.set(Presence.GONE);
    }

    // ---- methods for any thread ----

    boolean hasLeft() {
        return presence.get() == Presence.GONE;
    }

    /**
     * Returns whether the world must wait for the agent before it makes the frame after {@code
     * frame}.
     */
    boolean isAwaited(long frame) {
        return presence.get() == Presence.HERE && done.get() < rounds(frame);
    }

    /**
     * Returns whether {@code frame} must wait for the agent. The result is false if the world has
     * stopped waiting for the agent.
     */
    boolean holds(long frame) {
        return isAwaited(frame - 1) && givenUp != frame;
    }

    /** Returns whether the agent takes part in rounds, whether it is ready or not. */
    boolean isHere() {
        return presence.get() == Presence.HERE;
    }

    /**
     * Returns whether the agent receives a perception of a frame. The argument {@code told} is the
     * frame of the last perception that was sent to the agent.
     */
    public boolean isDue(long frame, long told) {
        Presence now = presence.get();
        return (now == Presence.HERE || now == Presence.AWAY)
                && frame >= origin + rounds(told) * wanted.every();
    }

    private long rounds(long frame) {
        long first = origin;
        return frame < first ? 0 : (frame - first) / wanted.every() + 1;
    }

    // ---- methods for the frame loop's thread ----

    /** Begins the first round, in the frame in which the agent joined. */
    public void begin(long frame) {
        origin = frame;
    }

    /**
     * Records that the world does not wait for this agent before a frame. Other agents may still
     * hold the frame.
     */
    void giveUp(long frame) {
        givenUp = frame;
    }

    /** Undoes {@link #giveUp}: the agent may hold the frame again. */
    void giveUpNone() {
        givenUp = -1;
    }

    /** Restarts the rounds: the first one begins with that frame. */
    void restart(long frame) {
        origin = frame;
        done.set(0);
        judged = 0;
        giveUpNone();
    }

    /**
     * Returns whether the agent takes part again. The agent does so if it became ready, or has a
     * new connection, after the world continued without it.
     */
    boolean isReturning() {
        return presence.get() == Presence.RETURNING;
    }

    /**
     * Includes a returning agent in the rounds again, from a frame that has not begun.
     *
     * @param granted false if an agent that is away stays away until it is ready again
     * @return true if an event had informed other agents that this agent was away
     */
    boolean takeBack(long frame, boolean granted) {
        if (!isReturning()) {
            return false;
        }
        if (away && !granted) {
            presence.compareAndSet(Presence.RETURNING, Presence.AWAY);
            return false;
        }
        boolean wasAway = away;
        away = false;
        missedUnawaited = false;
        lateInRow = 0;
        restart(frame);
        presence.compareAndSet(Presence.RETURNING, Presence.HERE);
        return wasAway;
    }

    /**
     * Restarts the rounds of an agent that has never been ready. The first round begins with the
     * given frame, in which another agent joins.
     */
    void putOff(long frame) {
        if (!playing) {
            restart(frame);
        }
    }

    /**
     * Ends all rounds up to a frame, because the world continues.
     *
     * @return true if the agent had not finished them
     */
    boolean miss(long frame) {
        long rounds = rounds(frame);
        if (rounds == judged) {
            return false;
        }
        judged = rounds;
        messagesWhenJudged = readyMessages.get();
        boolean late = done.get() < rounds && done.getAndAccumulate(rounds, Math::max) < rounds;
        lateInRow = late ? lateInRow + 1 : 0;
        return late;
    }

    /**
     * Returns the input that reports a missed round. Other agents are notified of each round for
     * which the world waited until the deadline. After the world stops waiting for the agent, other
     * agents are notified of the first missed round only.
     */
    AgentInput.Late late() {
        missed++;
        boolean told = !missedUnawaited;
        boolean goes =
                lateInRow >= MAX_LATE_ROUNDS
                        && presence.compareAndSet(Presence.HERE, Presence.AWAY);
        away |= goes;
        missedUnawaited = presence.get() != Presence.HERE;
        if (goes && readyMessages.get() != messagesWhenJudged) {
            // The agent has become ready since its rounds were counted, so it returns at once.
            presence.compareAndSet(Presence.AWAY, Presence.RETURNING);
        }
        return new AgentInput.Late(agent, missed, wanted.fallback(), told, goes);
    }

    /** Returns the input that reports the return of an agent that was away. */
    AgentInput.Back back() {
        return new AgentInput.Back(agent);
    }
}
