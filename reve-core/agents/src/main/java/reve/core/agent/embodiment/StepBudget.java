// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;
import java.util.TreeMap;

/**
 * Limit on the evaluation steps of agents' acts (expressions of actions and rules), so that no
 * agent delays the frames of others. All agents that acted recently share the steps of a frame
 * equally. An act may take more steps than the agent's share. The agent's shares of the next frames
 * then pay for the rest, and its further acts wait until the rest is paid. Agents that act for the
 * first time also share a separate pool, so that a client gains nothing by using new names. The
 * limit counts steps and frames instead of time, so the same acts wait for the same frames on every
 * machine. For the world's thread only.
 */
final class StepBudget {
    /**
     * Maximum number of steps of all agents together in one frame. Their evaluation takes a few
     * milliseconds.
     */
    static final int OF_FRAME = 60_000;

    /**
     * Maximum share of one agent [steps per frame]. It equals the limit of steps for one
     * evaluation.
     */
    static final int MOST = 20_000;

    /** Minimum share of one agent [steps per frame], for any number of agents. */
    static final int FEWEST = 500;

    /** Steps that each act costs in addition to those of its expressions. */
    static final int OF_ACT = 100;

    /** Number of frames after its last act during which an agent keeps a share. */
    static final int FRAMES_KEPT = 60;

    private final Map<String, Account> accounts = new TreeMap<>();

    /**
     * Remaining steps of the pool for agents in the frame of their first act. Each frame refills
     * the pool with {@link #MOST} steps; it never contains more than {@link #MOST}.
     */
    private long ofNewcomers = MOST;

    private long frame;

    private static final class Account {
        private final long firstFrame;
        private long steps;
        private long lastAct;

        Account(long frame, long steps) {
            this.firstFrame = frame;
            this.steps = steps;
        }
    }

    /** Returns whether an agent may act in a frame. */
    boolean hasLeft(String agent, long now) {
        refill(now);
        Account account = accounts.get(agent);
        if (account == null) {
            return ofNewcomers > 0;
        }
        return account.steps > 0 && (account.firstFrame != now || ofNewcomers > 0);
    }

    /** Charges an agent with the steps of an act. */
    void spend(String agent, long now, long steps) {
        refill(now);
        Account account =
                accounts.computeIfAbsent(
                        agent, name -> new Account(now, share(accounts.size() + 1)));
        long cost = OF_ACT + steps;
        account.steps -= cost;
        account.lastAct = now;
        if (account.firstFrame == now) {
            ofNewcomers -= cost;
        }
    }

    /**
     * Charges an agent with steps of rules. These rules were evaluated in the last frame because
     * the agent's acts had changed their inputs.
     */
    void charge(String agent, long now, long steps) {
        refill(now);
        Account account =
                accounts.computeIfAbsent(
                        agent, name -> new Account(now, share(accounts.size() + 1)));
        account.steps -= steps;
        account.lastAct = now;
        if (now - account.firstFrame <= 1) {
            ofNewcomers -= steps;
        }
    }

    private void refill(long now) {
        if (now == frame) {
            return;
        }
        long frames = Math.max(1, now - frame);
        frame = now;
        ofNewcomers = Math.min(MOST, ofNewcomers + frames * MOST);
        if (accounts.isEmpty()) {
            return;
        }
        long share = share(accounts.size());
        for (Account account : accounts.values()) {
            account.steps = Math.min(share, account.steps + frames * share);
        }
        accounts.values()
                .removeIf(account -> account.steps >= share && now - account.lastAct > FRAMES_KEPT);
    }

    private static long share(int agents) {
        return Math.clamp(OF_FRAME / agents, FEWEST, MOST);
    }
}
