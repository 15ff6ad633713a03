// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.perception.HeardEvent;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;

import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.List;
import java.util.OptionalLong;

/**
 * The last events that a client was told, so that one whose connection broke gets those it missed.
 * Bounded in time and bytes. Guarded by its session.
 */
final class EventLog {

    /** Most bytes that a client may have missed. */
    static final int MAX_BYTES = 4 * 1024 * 1024;

    private final long maxNanos;
    private final int maxBytes;
    private final Deque<Kept> kept = new ArrayDeque<>();
    private int bytes;
    private long lastForgotten = -1;

    private record Kept(HeardEvent.Told event, long nanos) {

        long frame() {
            return event.message().frame();
        }
    }

    EventLog(long maxNanos, int maxBytes) {
        this.maxNanos = maxNanos;
        this.maxBytes = maxBytes;
    }

    /** Keeps an event as it was sent; its bytes are shared with all who were sent it. */
    void add(HeardEvent.Told event, long nowNanos) {
        kept.addLast(new Kept(event, nowNanos));
        bytes += event.bytes().length;
        while (bytes > maxBytes || nowNanos - kept.getFirst().nanos > maxNanos) {
            Kept oldest = kept.removeFirst();
            bytes -= oldest.event.bytes().length;
            forget(oldest.frame());
        }
    }

    /** Of a frame, and of those before, not all is here. */
    void forget(long frame) {
        lastForgotten = Math.max(lastForgotten, frame);
    }

    /**
     * What happened after a frame, in order; nothing is encoded or copied. If some of it is
     * forgotten, an event {@code missed} is the first, and what is left of the forgotten frames is
     * not among the others.
     *
     * @param encoding of that event
     */
    List<HeardEvent.Told> after(long frame, Encoding encoding) {
        var events = new ArrayList<HeardEvent.Told>();
        if (lastForgotten > frame) {
            events.add(
                    HeardEvent.Told.of(
                            ServerMessage.Event.missed(
                                    OptionalLong.empty(), frame + 1, lastForgotten),
                            encoding));
        }
        long last = Math.max(frame, lastForgotten);
        for (Kept each : kept) {
            if (each.frame() > last) {
                events.add(each.event);
            }
        }
        return events;
    }
}
