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

/** What one agent has asked to perceive. Asked by its reader, served by the publisher. */
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
     * @param served counts the perceptions handed over
     */
    public PerceptionRequests(Outbox outbox, LongAdder served) {
        this.outbox = outbox;
        this.served = served;
    }

    /**
     * An agent in lock-step perceives the first frame of each of its rounds, until it asks for
     * something else.
     */
    public synchronized void follow(Turn followed, long answerTo) {
        turn = followed;
        everyId = answerTo;
        everyRelations = followed.wanted().relations();
    }

    /**
     * @param published the last frame published: what is asked for comes later
     * @throws BadMessage if one perception is asked for while another is on its way
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

    /** The world has become another one with that frame: the stream of perceptions begins anew. */
    synchronized void restart(long frame) {
        everyFrom = frame;
        outbox.restart();
    }

    /** Perceptions must not be older than a result that the agent has got. */
    public synchronized void notBefore(long frame) {
        notBefore = Math.max(notBefore, frame);
    }

    /** Returns true if the client is to perceive a frame. */
    public synchronized boolean isDue(long frame) {
        return frame >= notBefore && (isOnceDue(frame) || isEveryDue(frame));
    }

    /** What the agent perceives of a frame. */
    interface Views {
        /**
         * @return empty if it is not worked out yet; perhaps of an earlier frame
         */
        Optional<View> of(boolean relations);
    }

    /** Whether what is due in a frame has relations. */
    public synchronized boolean wantsRelations(long frame) {
        return frame >= notBefore
                && (onceRelations && isOnceDue(frame) || everyRelations && isEveryDue(frame));
    }

    /** Hands over what is due in a frame; false if something is not worked out yet. */
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
