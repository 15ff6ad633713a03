// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.lockstep;

import reve.core.agent.embodiment.AgentInput;
import reve.core.frame.FrameClock;
import reve.core.frame.FrameGate;

import java.util.Arrays;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.function.BooleanSupplier;
import java.util.function.Consumer;

/**
 * Holds the world until all agents in lock-step are ready whose round it is, or their deadlines
 * have passed. All are waited for at once, from the moment when the world could go on; nobody is
 * late before the world goes on without it. Agents that keep others waiting have {@link Allowances}
 * for it.
 */
public final class LockStep implements FrameGate {

    private static final Turn[] NOBODY = {};
    private static final long NO_FRAME = -1;

    private final Runnable wake;
    private final Waiting waiting;
    private final Consumer<AgentInput> news;
    private final Allowances allowances;

    /** Never changed, only replaced, with this held. */
    private volatile Turn[] turns = NOBODY;

    /** The place of one who was found missing: asked first, so that each is asked once a frame. */
    private volatile int missing;

    /** How many wait to be let into the world, which takes a frame. */
    private final AtomicInteger coming = new AtomicInteger();

    /** The frame that is held, {@link #NO_FRAME} if none is. */
    private volatile long held = NO_FRAME;

    /** Loop's thread: the frame that is due, and since when. */
    private long due = NO_FRAME;

    private long dueSinceNanos;

    /** How the frame loop's thread waits for agents. */
    public interface Waiting {

        /** Does nothing else. */
        Waiting IDLE =
                new Waiting() {
                    @Override
                    public void await(long nanoseconds, BooleanSupplier enough, FrameClock clock) {
                        clock.park(nanoseconds);
                    }

                    @Override
                    public void wake() {}
                };

        /**
         * @param enough true if there is nothing to wait for any more
         */
        void await(long nanoseconds, BooleanSupplier enough, FrameClock clock);

        /** Ends it; the thread is unparked, too. Any thread. */
        void wake();
    }

    /**
     * @param wake has the loop ask again
     * @param news takes the agents that missed a deadline, and those that came back after the world
     *     had stopped waiting for them; on the loop's thread
     */
    public LockStep(
            Runnable wake, Consumer<AgentInput> news, Allowances allowances, Waiting waiting) {
        this.wake = wake;
        this.news = news;
        this.allowances = allowances;
        this.waiting = waiting;
    }

    // ---- any thread ----

    /**
     * Somebody waits to be let in: agents that have not been ready yet do not keep the next frame
     * from being made.
     */
    public void comes() {
        coming.incrementAndGet();
        wake.run();
    }

    /** Who has come is in the world, or could not be let in. */
    public void came() {
        coming.decrementAndGet();
    }

    /** An agent is in the world: from now on it is waited for. */
    public synchronized void add(Turn turn) {
        if (turn.hasLeft()) {
            return;
        }
        Turn[] grown = Arrays.copyOf(turns, turns.length + 1);
        grown[turns.length] = turn;
        turns = grown;
    }

    /** How long its agents may keep others waiting. */
    public Allowances allowances() {
        return allowances;
    }

    /** An agent leaves. Does nothing if it is not there. */
    public void remove(Turn turn, long nowNanos) {
        synchronized (this) {
            turn.leave(nowNanos);
            turns = Arrays.stream(turns).filter(other -> other != turn).toArray(Turn[]::new);
        }
        changed();
    }

    /** Some agent may be ready. Wakes the loop only if nobody else is missing. */
    public void changed() {
        long frame = held;
        if (frame == NO_FRAME) {
            return;
        }
        if (!isAnybodyAwaited(frame)) {
            wake.run();
        }
    }

    private boolean isAnybodyAwaited(long frame) {
        Turn[] all = turns;
        int first = missing;
        for (int i = 0; i < all.length; i++) {
            int place = (first + i) % all.length;
            if (all[place].holds(frame)) {
                missing = place;
                return true;
            }
        }
        return false;
    }

    @Override
    public void wake() {
        waiting.wake();
    }

    // ---- loop's thread ----

    @Override
    public long nanosecondsToWait(long frame, long nowNanoseconds) {
        if (due != frame) {
            due = frame;
            dueSinceNanos = nowNanoseconds;
            allowances.due(nowNanoseconds);
        }
        held = frame; // before we look: who is ready from now on wakes us
        boolean somebodyComes = coming.get() > 0;
        Turn[] all = turns;
        for (Turn turn : all) {
            if (turn.isReturning() && turn.takeBack(frame, allowances.mayReturn(turn, all))) {
                news.accept(turn.back());
            }
            if (somebodyComes) {
                if (turn.holds(frame)) {
                    turn.allowance().answer(nowNanoseconds); // until now it held the frame
                }
                turn.putOff(frame);
            }
        }
        giveUpLate(all, frame, nowNanoseconds);
        long wait = 0;
        for (Turn turn : all) {
            if (turn.holds(frame)) {
                long left = nanosecondsLeft(turn, nowNanoseconds);
                wait = wait == 0 ? left : Math.min(wait, left);
            }
        }
        if (wait == 0) {
            held = NO_FRAME;
            goOnWithout(all, frame, nowNanoseconds);
        }
        return wait;
    }

    /** Before we ask who still holds the frame: an agent that is ready meanwhile wakes us then. */
    private void giveUpLate(Turn[] all, long frame, long nowNanos) {
        allowances.look(all);
        for (Turn turn : all) {
            boolean holds = turn.holds(frame);
            if (holds || turn.allowance().isSpent()) {
                allowances.note(turn, nowNanos);
            }
            if (holds && nanosecondsLeft(turn, nowNanos) <= 0) {
                turn.giveUp(frame);
            }
        }
    }

    private long nanosecondsLeft(Turn turn, long nowNanos) {
        return Math.min(
                dueSinceNanos + turn.deadlineNanos() - nowNanos,
                allowances.nanosecondsLeft(turn, nowNanos));
    }

    private void goOnWithout(Turn[] all, long frame, long nowNanos) {
        for (Turn turn : all) {
            if (turn.isAwaited(frame - 1)) {
                turn.allowance().answer(nowNanos);
            }
        }
        allowances.begin(all, nowNanos);
        for (Turn turn : all) {
            if (turn.miss(frame - 1)) {
                news.accept(turn.late());
            }
        }
    }

    @Override
    public void await(long nanoseconds, BooleanSupplier disturbed, FrameClock clock) {
        waiting.await(nanoseconds, () -> disturbed.getAsBoolean() || !isAnybodyAwaited(due), clock);
    }

    @Override
    public void paused() {
        due = NO_FRAME;
        held = NO_FRAME;
        allowances.forget();
        for (Turn turn : turns) {
            turn.giveUpNone();
        }
    }

    @Override
    public void continuesAfter(long frame) {
        due = NO_FRAME;
        allowances.forget();
        for (Turn turn : turns) {
            turn.restart(frame);
        }
    }
}
