package reve.core.agent;

import java.nio.charset.StandardCharsets;
import reve.core.agent.Outbox.Line;

/** What one agent has asked to perceive. Asked by its reader, served by the publisher. */
final class PerceptionRequests {

    private final Outbox outbox;
    private boolean once;
    private long onceId;
    private long onceFrom;
    private int every;
    private long everyId;
    private long everyFrom;
    private long notBefore;

    PerceptionRequests(Outbox outbox) {
        this.outbox = outbox;
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
    }

    /** Perceptions must not be older than a result that the agent has got. */
    synchronized void notBefore(long frame) {
        notBefore = Math.max(notBefore, frame);
    }

    synchronized boolean isDue(long frame) {
        return frame >= notBefore && (isOnceDue(frame) || isEveryDue(frame));
    }

    /**
     * Hands over what is due in a frame.
     *
     * @param body the frame's items
     * @return how many perceptions were handed over
     */
    synchronized int serve(long frame, byte[] body) {
        int served = 0;
        if (frame >= notBefore && isOnceDue(frame)) {
            outbox.offerAnswer(new Line(head(onceId), body));
            once = false;
            served++;
        }
        if (frame >= notBefore && isEveryDue(frame)) {
            outbox.offerLatest(new Line(head(everyId), body));
            everyFrom = frame + every;
            served++;
        }
        return served;
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
