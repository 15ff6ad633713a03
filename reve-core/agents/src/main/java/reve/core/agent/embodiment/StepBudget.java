// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import java.util.Map;
import java.util.TreeMap;

/**
 * How many steps the acts of agents may take, so that no agent takes the frames of the others. All
 * agents that have acted of late share the steps of a frame alike. What an act takes beyond its
 * agent's share is a debt, which the shares of the following frames pay off; until then the agent
 * waits. Agents that act for the first time also share a pool of their own, so that nobody gains by
 * coming under other names. Counts steps and frames, never time: the same acts wait for the same
 * frames on every machine. World's thread.
 */
final class StepBudget {
    /** Steps of all agents in one frame: about 6 ms. */
    static final int OF_FRAME = 60_000;

    /** Most steps of one agent in one frame: those of one evaluation. */
    static final int MOST = 20_000;

    /** Fewest steps of one agent in one frame, however many others there are. */
    static final int FEWEST = 500;

    /** Steps of an act besides those of its expressions. */
    static final int OF_ACT = 100;

    /** Frames after its last act for which an agent has a share. */
    static final int FRAMES_KEPT = 60;

    private final Map<String, Account> accounts = new TreeMap<>();

    /** Left for agents in the frame of their first act: those of one evaluation in each frame. */
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

    /** True if an agent may act in a frame. */
    boolean hasLeft(String agent, long now) {
        refill(now);
        Account account = accounts.get(agent);
        if (account == null) {
            return ofNewcomers > 0;
        }
        return account.steps > 0 && (account.firstFrame != now || ofNewcomers > 0);
    }

    /** An agent has acted. */
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
     * Charges an agent for what the last frame computed because of its acts: the evaluation of
     * rules that read what they changed.
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
