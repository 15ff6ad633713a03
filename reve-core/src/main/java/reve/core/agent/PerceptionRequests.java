package reve.core.agent;

import java.util.Optional;
import java.util.concurrent.atomic.LongAdder;
import org.jspecify.annotations.Nullable;
import reve.core.agent.Outbox.Line;

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

    /** @param served counts the perceptions handed over */
    PerceptionRequests(Outbox outbox, LongAdder served) {
        this.outbox = outbox;
        this.served = served;
    }

    /** An agent in lock-step perceives the first frame of each of its rounds, until it asks for something else. */
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
            throw new BadMessage(perceive.id(), "perceive-pending",
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
        /** @return empty if the frame is gone */
        Optional<View> of(boolean relations);
    }

    /** Hands over what is due in a frame; false if the frame is gone. */
    synchronized boolean serve(long frame, Views views, Encoding encoding, Telling telling) {
        if (frame >= notBefore && isOnceDue(frame)) {
            Optional<View> view = views.of(onceRelations);
            if (view.isEmpty()) {
                return false;
            }
            served.increment();
            outbox.offerAnswer(line(encoding, onceId, telling.whole(view.get(), encoding), telling));
            once = false;
        }
        if (frame >= notBefore && isEveryDue(frame)) {
            Optional<View> view = views.of(everyRelations);
            if (view.isEmpty()) {
                return false;
            }
            served.increment();
            update(view.get(), encoding, telling);
            everyFrom = frame + every;
            told = frame;
        }
        return true;
    }

    /** Tells the difference to what the client was handed last, whenever that is. */
    private void update(View view, Encoding encoding, Telling telling) {
        View base;
        Line line;
        do {
            base = outbox.told();
            line = line(encoding, everyId,
                    base == null ? telling.whole(view, encoding) : telling.since(base, view, encoding), telling);
        } while (!outbox.offerLatest(line, view, base));
    }

    private static Line line(Encoding encoding, long id, View.Told told, Telling telling) {
        return new Line(telling.head(encoding, id, told), told.bytes());
    }

    private boolean isOnceDue(long frame) {
        return once && frame >= onceFrom;
    }

    private boolean isEveryDue(long frame) {
        return turn == null ? every > 0 && frame >= everyFrom : turn.isDue(frame, told);
    }
}
