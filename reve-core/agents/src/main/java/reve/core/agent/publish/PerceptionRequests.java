// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.publish;

import org.jspecify.annotations.Nullable;

import reve.core.agent.lockstep.Turn;
import reve.core.agent.net.Outbox;
import reve.core.agent.perception.View;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;

import java.util.Optional;
import java.util.concurrent.atomic.LongAdder;

/**
 * The perceptions that one agent has requested. The thread that reads its messages adds requests;
 * the publisher serves them.
 */
public final class PerceptionRequests {

    private final Outbox outbox;
    private final LongAdder served;
    private boolean once;
    private long onceId;
    private long onceFrom;
    private boolean onceRelations;
    private int every;
    private long everyId;
    private long everyFrom;
    private boolean everyRelations;
    private @Nullable Turn turn;
    private long told = -1;
    private long notBefore;

    /**
     * @param served counts the perceptions that were queued
     */
    public PerceptionRequests(Outbox outbox, LongAdder served) {
        this.outbox = outbox;
        this.served = served;
    }

    /**
     * Makes an agent in lock-step perceive the first frame of each of its rounds, until it requests
     * something else.
     */
    public synchronized void follow(Turn followed, long answerTo) {
        turn = followed;
        everyId = answerTo;
        everyRelations = followed.wanted().relations();
    }

    /**
     * @param published the last published frame; requests are served with later ones
     * @throws BadMessage if the client requests a single perception while another one is pending
     */
    public synchronized void ask(ClientMessage.Perceive perceive, long published)
            throws BadMessage {
        if (perceive.every() != ClientMessage.Perceive.ONCE) {
            every = perceive.every();
            everyId = perceive.id();
            everyFrom = published + 1;
            everyRelations = perceive.relations();
            turn = null;
            outbox.restart();
            return;
        }
        if (once || outbox.hasAnswer()) {
            throw new BadMessage(
                    perceive.id(),
                    "perceive-pending",
                    "the perception asked for before is still on its way",
                    "wait for it, or perceive every N frames");
        }
        once = true;
        onceId = perceive.id();
        onceFrom = published + 1;
        onceRelations = perceive.relations();
    }

    /** Begins a new stream of perceptions, because the world was rewound in that frame. */
    synchronized void restart(long frame) {
        everyFrom = frame;
        outbox.restart();
    }

    /** Requires that perceptions are not older than a result that was sent to the agent. */
    public synchronized void notBefore(long frame) {
        notBefore = Math.max(notBefore, frame);
    }

    /** Returns whether the client perceives a frame. */
    public synchronized boolean isDue(long frame) {
        return frame >= notBefore && (isOnceDue(frame) || isEveryDue(frame));
    }

    /** The agent's perceptions of a frame. */
    interface Views {
        /**
         * @return empty if it is not computed yet; it may be of an earlier frame
         */
        Optional<View> of(boolean relations);
    }

    /** Returns whether the perception that is due in a frame has relations. */
    public synchronized boolean wantsRelations(long frame) {
        return frame >= notBefore
                && (onceRelations && isOnceDue(frame) || everyRelations && isEveryDue(frame));
    }

    /** Queues the perceptions that are due in a frame; returns false if one is not computed yet. */
    synchronized boolean serve(long frame, Views views) {
        boolean all = true;
        if (frame >= notBefore && isOnceDue(frame)) {
            Optional<View> view = views.of(onceRelations);
            if (view.isPresent() && view.get().frame() >= Math.max(notBefore, onceFrom)) {
                served.increment();
                outbox.offerAnswer(onceId, view.get());
                once = false;
            } else {
                all = false;
            }
        }
        if (frame >= notBefore && isEveryDue(frame)) {
            Optional<View> view = views.of(everyRelations);
            if (view.isPresent()
                    && view.get().frame() >= notBefore
                    && isEveryDue(view.get().frame())) {
                served.increment();
                outbox.offerLatest(everyId, view.get());
                told = view.get().frame();
                everyFrom = told + every;
            } else {
                all = false;
            }
        }
        return all;
    }

    private boolean isOnceDue(long frame) {
        return once && frame >= onceFrom;
    }

    private boolean isEveryDue(long frame) {
        return turn == null ? every > 0 && frame >= everyFrom : turn.isDue(frame, told);
    }
}
