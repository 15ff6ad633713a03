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
 * The gate of a frame loop: it delays frames for agents in lock-step. A frame that ends an agent's
 * round begins when this agent is ready or its deadline has passed. All deadlines begin at the time
 * when the world could make the frame. An agent counts as late only when the world continues
 * without it. {@link Allowances} limit agents that delay others.
 */
public final class LockStep implements FrameGate {

    private static final Turn[] NOBODY = {};
    private static final long NO_FRAME = -1;

    /**
     * Maximum time between two checks of the gate [ns]. A pause of twice this time between two
     * checks means that the process was suspended or busy. Such a pause does not count for
     * deadlines and allowances.
     */
    private static final long CHECK_NANOS = 250_000_000;

    private final Runnable wake;
    private final Waiting waiting;
    private final Consumer<AgentInput> news;
    private final Allowances allowances;

    /**
     * The agents in lock-step. The array is replaced, never changed; the replacement happens under
     * this object's lock.
     */
    private volatile Turn[] turns = NOBODY;

    /**
     * Index of an agent that was not ready at the last check. This agent is checked first, so that
     * each agent is checked only about once per frame.
     */
    private volatile int missing;

    /** Number of agents that wait to join. The world executes their joins in the next frame. */
    private final AtomicInteger coming = new AtomicInteger();

    /**
     * Number of agents that must be waiting to join before the first frame may begin; 0 after the
     * first frame. While the frame loop runs, only its thread uses this field.
     */
    private int expected;

    /** The number of the frame that the gate holds; {@link #NO_FRAME} if it holds none. */
    private volatile long held = NO_FRAME;

    /**
     * The number of the frame that is due. The next field is the time at which it became due. Only
     * the thread of the frame loop uses both.
     */
    private long due = NO_FRAME;

    private long dueSinceNanos;

    /** Time of the last check. */
    private long askedNanos;

    /** The way in which the frame loop's thread waits for agents. */
    public interface Waiting {

        /** Waits without other work. */
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
         * Waits until {@code enough} returns true or the time has passed.
         *
         * @param enough returns true when the wait must end
         */
        void await(long nanoseconds, BooleanSupplier enough, FrameClock clock);

        /** Ends the wait; the caller also unparks the thread. For any thread. */
        void wake();
    }

    /**
     * @param wake wakes the frame loop, so that it checks the gate again
     * @param news receives an input for each agent that missed a deadline, and for each agent that
     *     returned from absence; called on the loop's thread
     */
    public LockStep(
            Runnable wake, Consumer<AgentInput> news, Allowances allowances, Waiting waiting) {
        this.wake = wake;
        this.news = news;
        this.allowances = allowances;
        this.waiting = waiting;
    }

    // ---- methods for any thread ----

    /**
     * Records that an agent waits to join. Agents that have never been ready do not delay the next
     * frame before this agent has joined.
     */
    public void comes() {
        coming.incrementAndGet();
        wake.run();
    }

    /**
     * Delays the first frame until this number of agents waits to join. All these agents then join
     * in the same frame. Call this method before the loop runs.
     */
    public void expect(int agents) {
        expected = agents;
    }

    /** Returns the number of agents in lock-step. */
    public int size() {
        return turns.length;
    }

    /** Records that a waiting agent has joined or was refused. */
    public void came() {
        coming.decrementAndGet();
    }

    /** Adds an agent that is in the world. The world waits for this agent from now on. */
    public synchronized void add(Turn turn) {
        if (turn.hasLeft()) {
            return;
        }
        Turn[] grown = Arrays.copyOf(turns, turns.length + 1);
        grown[turns.length] = turn;
        turns = grown;
    }

    /** Returns the limits on the delays by the world's agents. */
    public Allowances allowances() {
        return allowances;
    }

    /** Removes an agent that leaves the world; does nothing if it was removed before. */
    public void remove(Turn turn, long nowNanos) {
        synchronized (this) {
            turn.leave(nowNanos);
            turns = Arrays.stream(turns).filter(other -> other != turn).toArray(Turn[]::new);
        }
        changed();
    }

    /**
     * Notifies the gate that an agent may have become ready. Wakes the frame loop only if no other
     * agent still holds the frame.
     */
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

    // ---- methods for the frame loop's thread ----

    @Override
    public long nanosecondsToWait(long frame, long nowNanoseconds) {
        if (due != frame) {
            due = frame;
            dueSinceNanos = nowNanoseconds;
            allowances.due(nowNanoseconds);
        } else if (nowNanoseconds - askedNanos > 2 * CHECK_NANOS) {
            dueSinceNanos += nowNanoseconds - askedNanos;
            allowances.postpone(nowNanoseconds - askedNanos);
        }
        askedNanos = nowNanoseconds;
        if (!isExpectedHere()) {
            dueSinceNanos = nowNanoseconds;
            return CHECK_NANOS;
        }
        expected = 0;
        // This field is set before the check, so that an agent that becomes ready later wakes the
        // loop.
        held = frame;
        boolean somebodyComes = coming.get() > 0;
        Turn[] all = turns;
        for (Turn turn : all) {
            if (turn.isReturning() && turn.takeBack(frame, allowances.mayReturn(turn, all))) {
                news.accept(turn.back());
            }
            if (somebodyComes) {
                if (turn.holds(frame)) {
                    // The agent has delayed the frame until now. Its allowance pays for this time.
                    turn.allowance().answer(nowNanoseconds);
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
        return Math.min(wait, CHECK_NANOS);
    }

    /**
     * Stops waiting for agents whose time is over. This method must run before the check for agents
     * that still hold the frame. Otherwise, an agent that becomes ready in between would not wake
     * the frame loop.
     */
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
        waiting.await(
                nanoseconds,
                () -> disturbed.getAsBoolean() || isExpectedHere() && !isAnybodyAwaited(due),
                clock);
    }

    private boolean isExpectedHere() {
        return coming.get() >= expected;
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
