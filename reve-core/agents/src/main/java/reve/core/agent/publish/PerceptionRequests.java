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
 * The requests of one client for single perceptions or a stream of perceptions. The thread that
 * reads the client's messages adds requests. The publisher serves them.
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
     * Requests a perception of the first frame of each round of an agent in lock-step, until the
     * agent requests other perceptions.
     */
    public synchronized void follow(Turn followed, long answerTo) {
        turn = followed;
        everyId = answerTo;
        everyRelations = followed.wanted().relations();
    }

    /**
     * Handles a request for perceptions.
     *
     * @param published number of the last published frame; the request is served with a later frame
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

    /**
     * Begins a new stream of perceptions with a frame, because the world was rewound in that frame.
     */
    synchronized void restart(long frame) {
        everyFrom = frame;
        outbox.restart();
    }

    /**
     * Requires that later perceptions are not older than {@code frame}, the frame of a result that
     * was sent to the agent.
     */
    public synchronized void notBefore(long frame) {
        notBefore = Math.max(notBefore, frame);
    }

    /** Returns whether a perception of this frame must be sent to the client. */
    public synchronized boolean isDue(long frame) {
        return frame >= notBefore && (isOnceDue(frame) || isEveryDue(frame));
    }

    /** Source of the client's views of a frame. */
    interface Views {
        /**
         * Returns the client's view.
         *
         * @return the view, possibly of an earlier frame; empty if it is not computed yet
         */
        Optional<View> of(boolean relations);
    }

    /**
     * Returns whether a perception of this frame must be sent to the client and must contain
     * relations.
     */
    public synchronized boolean wantsRelations(long frame) {
        return frame >= notBefore
                && (onceRelations && isOnceDue(frame) || everyRelations && isEveryDue(frame));
    }

    /**
     * Queues the perceptions of a frame that must be sent to the client. Returns false if one of
     * them is not computed yet.
     */
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
