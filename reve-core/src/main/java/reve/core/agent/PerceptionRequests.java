// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import org.jspecify.annotations.Nullable;

import java.util.Optional;
import java.util.concurrent.atomic.LongAdder;

/** What one agent has asked to perceive. Asked by its reader, served by the publisher. */
final class PerceptionRequests {

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
    PerceptionRequests(Outbox outbox, LongAdder served) {
        this.outbox = outbox;
        this.served = served;
    }

    /**
     * An agent in lock-step perceives the first frame of each of its rounds, until it asks for
     * something else.
     */
    synchronized void follow(Turn its, long answerTo) {
        turn = its;
        everyId = answerTo;
        everyRelations = its.wanted().relations();
    }

    /**
     * @param published the last frame published: what is asked for comes later
     * @throws BadMessage if one perception is asked for while another is on its way
     */
    synchronized void ask(ClientMessage.Perceive perceive, long published) throws BadMessage {
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
    synchronized void notBefore(long frame) {
        notBefore = Math.max(notBefore, frame);
    }

    synchronized boolean isDue(long frame) {
        return frame >= notBefore && (isOnceDue(frame) || isEveryDue(frame));
    }

    /** What the agent perceives of a frame. */
    interface Views {
        /**
         * @return empty if the frame is gone
         */
        Optional<View> of(boolean relations);
    }

    /** Hands over what is due in a frame; false if the frame is gone. */
    synchronized boolean serve(long frame, Views views) {
        if (frame >= notBefore && isOnceDue(frame)) {
            Optional<View> view = views.of(onceRelations);
            if (view.isEmpty()) {
                return false;
            }
            served.increment();
            outbox.offerAnswer(onceId, view.get());
            once = false;
        }
        if (frame >= notBefore && isEveryDue(frame)) {
            Optional<View> view = views.of(everyRelations);
            if (view.isEmpty()) {
                return false;
            }
            served.increment();
            outbox.offerLatest(everyId, view.get());
            everyFrom = frame + every;
            told = frame;
        }
        return true;
    }

    private boolean isOnceDue(long frame) {
        return once && frame >= onceFrom;
    }

    private boolean isEveryDue(long frame) {
        return turn == null ? every > 0 && frame >= everyFrom : turn.isDue(frame, told);
    }
}
