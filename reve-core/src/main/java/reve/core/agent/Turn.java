package reve.core.agent;

import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.atomic.AtomicReference;

/**
 * One agent in lock-step, and how far it has come. A round begins with every Nth frame, the first
 * of which is the one the agent came in; the agent perceives that frame, and the next one does not
 * begin before it is ready.
 */
final class Turn {

    private enum Presence {
        /** It is waited for. */
        HERE,
        /** Its connection is broken: nobody waits. */
        AWAY,
        /** Its connection is there again: rounds begin anew with the next frame. */
        RETURNING,
        /** It has left the world. */
        GONE
    }

    private final String agent;
    private final ClientMessage.LockStep wanted;
    private final long deadlineNanos;
    /** Rounds that the agent has done with, or was too late for. */
    private final AtomicLong done = new AtomicLong();

    private final AtomicReference<Presence> presence = new AtomicReference<>(Presence.HERE);
    /** It has been ready at least once. */
    private volatile boolean playing;
    /** The frame of the first round. Set on the loop's thread. */
    private volatile long origin = Long.MAX_VALUE;

    // Loop's thread.
    private long missed;
    private boolean missedAway;

    /** @param deadlineNanos longest wait for it [ns] */
    Turn(String agent, ClientMessage.LockStep wanted, long deadlineNanos) {
        this.agent = agent;
        this.wanted = wanted;
        this.deadlineNanos = deadlineNanos;
    }

    ClientMessage.LockStep wanted() {
        return wanted;
    }

    long deadlineNanos() {
        return deadlineNanos;
    }

    // ---- its connection ----

    /** The agent is done with the oldest round that is open. */
    void ready() {
        playing = true;
        done.incrementAndGet();
    }

    /**
     * The agent is done with what it perceived in a frame, unless that was not the last
     * round that began.
     */
    void ready(long frame, long published) {
        playing = true;
        if (frame <= published) {
            done.accumulateAndGet(rounds(frame), Math::max);
        }
    }

    void breakOff() {
        presence.set(Presence.AWAY);
    }

    void comeBack() {
        presence.set(Presence.RETURNING);
    }

    void leave() {
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

    /** Whether the agent perceives a frame, having been told last of another one. */
    boolean isDue(long frame, long told) {
        return presence.get() == Presence.HERE && frame >= origin + rounds(told) * wanted.every();
    }

    private long rounds(long frame) {
        long first = origin;
        return frame < first ? 0 : (frame - first) / wanted.every() + 1;
    }

    // ---- loop's thread ----

    /** The agent came into the world in that frame. */
    void begin(long frame) {
        origin = frame;
    }

    /** Rounds begin anew in that frame. */
    void restart(long frame) {
        origin = frame;
        done.set(0);
    }

    /** Who is returning is here from that frame on, which has not been begun. */
    void takeBack(long frame) {
        if (presence.get() == Presence.RETURNING) {
            missedAway = false;
            restart(frame);
            presence.compareAndSet(Presence.RETURNING, Presence.HERE);
        }
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
        return done.get() < rounds && done.getAndAccumulate(rounds, Math::max) < rounds;
    }

    /**
     * What comes of a missed round. The others hear of the first one that a broken
     * connection costs, not of each.
     */
    AgentInput.Late late() {
        missed++;
        boolean told = !missedAway;
        missedAway = presence.get() != Presence.HERE;
        return new AgentInput.Late(agent, missed, wanted.fallback(), told);
    }
}
