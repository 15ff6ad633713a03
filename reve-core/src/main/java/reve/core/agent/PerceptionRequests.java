package reve.core.agent;

import java.nio.charset.StandardCharsets;
import java.util.Optional;
import java.util.concurrent.atomic.LongAdder;
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
    private long notBefore;

    /** @param served counts the perceptions handed over */
    PerceptionRequests(Outbox outbox, LongAdder served) {
        this.outbox = outbox;
        this.served = served;
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

    /** Perceptions must not be older than a result that the agent has got. */
    synchronized void notBefore(long frame) {
        notBefore = Math.max(notBefore, frame);
    }

    synchronized boolean isDue(long frame) {
        return frame >= notBefore && (isOnceDue(frame) || isEveryDue(frame));
    }

    /** What agents perceive of a frame. */
    interface Bodies {
        /** @return empty if the frame is gone */
        Optional<byte[]> of(boolean relations);
    }

    /** Hands over what is due in a frame; false if the frame is gone. */
    synchronized boolean serve(long frame, Bodies bodies) {
        if (frame >= notBefore && isOnceDue(frame)) {
            Optional<byte[]> body = bodies.of(onceRelations);
            if (body.isEmpty()) {
                return false;
            }
            served.increment();
            outbox.offerAnswer(new Line(head(onceId), body.get()));
            once = false;
        }
        if (frame >= notBefore && isEveryDue(frame)) {
            Optional<byte[]> body = bodies.of(everyRelations);
            if (body.isEmpty()) {
                return false;
            }
            served.increment();
            outbox.offerLatest(new Line(head(everyId), body.get()));
            everyFrom = frame + every;
        }
        return true;
    }

    private boolean isOnceDue(long frame) {
        return once && frame >= onceFrom;
    }

    private boolean isEveryDue(long frame) {
        return every > 0 && frame >= everyFrom;
    }

    private static byte[] head(long id) {
        String head = "{\"t\":\"perception\"," + (id == ClientMessage.NO_ID ? "" : "\"id\":" + id + ",");
        return head.getBytes(StandardCharsets.US_ASCII);
    }
}
