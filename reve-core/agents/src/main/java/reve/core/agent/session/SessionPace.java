// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.lockstep.Allowance;
import reve.core.agent.lockstep.LockStep;
import reve.core.agent.lockstep.Turn;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.publish.PerceptionRequests;

import java.util.Optional;

/**
 * The pace of a session relative to its world. The world waits for an agent in lock-step, and does
 * not wait for an agent in real time. For any thread.
 */
final class SessionPace {
    private final LockStep lockStep;

    /** The rounds of an agent in lock-step; null for an agent in real time. */
    private final @Nullable Turn turn;

    /**
     * True while the client is an agent in real time that has a body. Agents in lock-step may delay
     * such an agent. Guarded by this object's lock.
     */
    private boolean inRealTime;

    /** True after the agent has left. Guarded by this object's lock. */
    private boolean left;

    SessionPace(LockStep lockStep, @Nullable Turn turn) {
        this.lockStep = lockStep;
        this.turn = turn;
    }

    boolean isLockStep() {
        return turn != null;
    }

    /** Returns the rounds of the agent; null for an agent in real time. */
    @Nullable Turn turn() {
        return turn;
    }

    /**
     * Requests a perception for each round of an agent in lock-step. Does nothing for other agents.
     */
    void follow(PerceptionRequests requests, long helloId) {
        if (turn != null) {
            requests.follow(turn, helloId);
        }
    }

    /** Records that the agent has a body from this frame on. For the world's thread only. */
    synchronized void begin(long frame) {
        if (turn != null) {
            turn.begin(frame);
            lockStep.add(turn);
        } else if (!left) {
            inRealTime = true;
            lockStep.allowances().addRealTime(1);
        }
    }

    /** Ends the participation of the agent, so that the world does not wait for it. */
    void leave() {
        synchronized (this) {
            left = true;
            if (inRealTime) {
                lockStep.allowances().addRealTime(-1);
            }
        }
        if (turn != null) {
            lockStep.remove(turn, System.nanoTime());
        }
    }

    /** Records that the connection broke. The world then does not wait for the agent. */
    void breakOff(long nowNanos) {
        if (turn != null) {
            turn.breakOff(nowNanos);
            lockStep.changed();
        }
    }

    /** Records that another connection continues the session. */
    void comeBack() {
        if (turn != null) {
            turn.comeBack();
        }
    }

    /**
     * Throws an exception if the agent is not in lock-step. This check is for messages that only
     * agents in lock-step may send.
     *
     * @param client names the client in the refusal
     */
    void requireLockStep(long id, Object client) throws BadMessage {
        if (turn == null) {
            throw new BadMessage(
                    id,
                    "not-lock-step",
                    client + " is not in lock-step",
                    "send hello with \"time\":{\"mode\":\"lock-step\"}");
        }
    }

    /**
     * Ends the current round of an agent in lock-step. Does nothing for other agents.
     *
     * @param published number of the newest published frame
     */
    void endRound(ClientMessage.Ready ready, long published) {
        if (turn != null) {
            if (ready.frame().isPresent()) {
                turn.ready(ready.frame().getAsLong(), published, System.nanoTime());
            } else {
                turn.ready(System.nanoTime());
            }
            lockStep.changed();
        }
    }

    /** Returns whether the agent is in lock-step and uses this allowance. */
    boolean uses(Allowance allowance) {
        return turn != null && turn.allowance() == allowance;
    }

    /** Returns the lock-step settings for the welcome; empty for an agent in real time. */
    Optional<ServerMessage.Rhythm> rhythm() {
        return Optional.ofNullable(turn)
                .map(
                        own ->
                                new ServerMessage.Rhythm(
                                        own.wanted().every(), own.deadlineNanos() / 1e9));
    }
}
