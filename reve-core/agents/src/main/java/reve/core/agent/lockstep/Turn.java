// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.protocol.ClientMessage;

import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.AtomicReference;

/**
 * One agent in lock-step, and how far it has come. A round begins with every Nth frame, the first
 * of which is the one the agent came in; the agent perceives that frame, and the next one does not
 * begin before it is ready.
 */
public final class Turn {

    private enum Presence {
        /** It is waited for. */
        HERE,
        /** It was late too often in a row: the world does not wait until it says ready. */
        AWAY,
        /** Its connection is broken: the world does not wait until there is another one. */
        BROKEN,
        /** It is there again: its rounds restart with the next frame. */
        RETURNING,
        /** It has left the world. */
        GONE
    }

    /** Rounds in a row for which an agent may be late; then the world no longer waits for it. */
    static final int MAX_LATE_ROUNDS = 3;

    private final String agent;
    private final ClientMessage.LockStep wanted;
    private final long deadlineNanos;
    private final Allowance allowance;

    /** Rounds that the agent has done with, or was too late for. */
    private final AtomicLong done = new AtomicLong();

    /** Messages by which the agent said that it is done with a round, counted before they act. */
    private final AtomicLong said = new AtomicLong();

    private final AtomicReference<Presence> presence = new AtomicReference<>(Presence.HERE);

    /** It has been ready at least once. */
    private volatile boolean playing;

    /** The frame of the first round. Set on the loop's thread. */
    private volatile long origin = Long.MAX_VALUE;

    /** The frame that is not held for the agent any more. Set on the loop's thread. */
    private volatile long givenUp = -1;

    // Loop's thread.
    private long missed;
    private boolean missedUnawaited;
    private int lateInRow;

    /** Rounds that were found to be done or missed, and {@link #said} at that time. */
    private long judged;

    private long saidWhenJudged;

    /** The others were told that it is away. */
    private boolean away;

    /**
     * @param deadlineNanos longest wait for it [ns]
     * @param allowance what it uses up by keeping others waiting
     */
    public Turn(
            String agent, ClientMessage.LockStep wanted, long deadlineNanos, Allowance allowance) {
        this.agent = agent;
        this.wanted = wanted;
        this.deadlineNanos = deadlineNanos;
        this.allowance = allowance;
    }

    /** Returns what the hello asked for. */
    public ClientMessage.LockStep wanted() {
        return wanted;
    }

    /** Returns the longest wait for the agent [ns]. */
    public long deadlineNanos() {
        return deadlineNanos;
    }

    /** Returns what the agent uses up by keeping others waiting. */
    public Allowance allowance() {
        return allowance;
    }

    // ---- its connection ----

    /** The agent is done with the oldest round that is open. */
    public void ready(long nowNanos) {
        playing = true;
        allowance.answer(nowNanos); // before it counts: the loop reads the two in turn
        done.incrementAndGet();
        speak();
    }

    /**
     * The agent is done with what it perceived in a frame, unless that was not the last round that
     * began.
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
        said.incrementAndGet();
        presence.compareAndSet(Presence.AWAY, Presence.RETURNING);
    }

    /** The connection broke: the world does not wait until there is another one. */
    public void breakOff(long nowNanos) {
        allowance.answer(nowNanos);
        presence.set(Presence.BROKEN);
    }

    /** Another connection goes on: rounds restart with the next frame. */
    public void comeBack() {
        presence.set(Presence.RETURNING);
    }

    void leave(long nowNanos) {
        allowance.answer(nowNanos);
        presence.set(Presence.GONE);
    }

    // ---- any thread ----

    boolean hasLeft() {
        return presence.get() == Presence.GONE;
    }

    /** Whether the world has to wait for the agent before it makes the frame after that one. */
    boolean isAwaited(long frame) {
        return presence.get() == Presence.HERE && done.get() < rounds(frame);
    }

    /** Whether it is waited for before that frame, and not given up. */
    boolean holds(long frame) {
        return isAwaited(frame - 1) && givenUp != frame;
    }

    /** Whether it takes part, ready or not. */
    boolean isHere() {
        return presence.get() == Presence.HERE;
    }

    /** Whether the agent perceives a frame, having been told last of another one. */
    public boolean isDue(long frame, long told) {
        Presence now = presence.get();
        return (now == Presence.HERE || now == Presence.AWAY)
                && frame >= origin + rounds(told) * wanted.every();
    }

    private long rounds(long frame) {
        long first = origin;
        return frame < first ? 0 : (frame - first) / wanted.every() + 1;
    }

    // ---- loop's thread ----

    /** The agent came into the world in that frame. */
    public void begin(long frame) {
        origin = frame;
    }

    /** That frame is not held for it any more, although others may hold it. */
    void giveUp(long frame) {
        givenUp = frame;
    }

    /** It may hold every frame, as before. */
    void giveUpNone() {
        givenUp = -1;
    }

    /** Rounds begin anew in that frame. */
    void restart(long frame) {
        origin = frame;
        done.set(0);
        judged = 0;
        giveUpNone();
    }

    /** Whether the agent was ready, or has another connection, after the world went on without. */
    boolean isReturning() {
        return presence.get() == Presence.RETURNING;
    }

    /**
     * Lets an agent that is returning take part again from that frame on, which has not been begun.
     *
     * @param granted false if an agent that is away stays away, until it is ready another time
     * @return true if the others were told that it was away
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
     * Somebody comes into the world in that frame: who has not been ready yet begins with it, too.
     */
    void putOff(long frame) {
        if (!playing) {
            restart(frame);
        }
    }

    /** Ends the rounds up to a frame. @return true if the agent was not done with them */
    boolean miss(long frame) {
        long rounds = rounds(frame);
        if (rounds == judged) {
            return false;
        }
        judged = rounds;
        saidWhenJudged = said.get();
        boolean late = done.get() < rounds && done.getAndAccumulate(rounds, Math::max) < rounds;
        lateInRow = late ? lateInRow + 1 : 0;
        return late;
    }

    /**
     * Returns what comes of a missed round. The others are told each round that the world waited
     * for in vain and the first that a broken connection costs, not those that follow.
     */
    AgentInput.Late late() {
        missed++;
        boolean told = !missedUnawaited;
        boolean goes =
                lateInRow >= MAX_LATE_ROUNDS
                        && presence.compareAndSet(Presence.HERE, Presence.AWAY);
        away |= goes;
        missedUnawaited = presence.get() != Presence.HERE;
        if (goes && said.get() != saidWhenJudged) { // it was ready at this very moment
            presence.compareAndSet(Presence.AWAY, Presence.RETURNING);
        }
        return new AgentInput.Late(agent, missed, wanted.fallback(), told, goes);
    }

    /** Returns the event for others about an agent that was away and takes part again. */
    AgentInput.Back back() {
        return new AgentInput.Back(agent);
    }
}
