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
 * The last events sent to a client, so that a resumed session receives the events that it missed.
 * Events that are too old are discarded. The oldest events are also discarded if the total size
 * exceeds its limit. Guarded by the lock of {@link SessionOutput}.
 */
final class EventLog {

    /** Maximum total size of the stored events [bytes]. */
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

    /** Adds an event that was sent, whose bytes are shared with other clients. */
    void add(HeardEvent.Told event, long nowNanos) {
        kept.addLast(new Kept(event, nowNanos));
        bytes += event.bytes().length;
        while (bytes > maxBytes || nowNanos - kept.getFirst().nanos > maxNanos) {
            Kept oldest = kept.removeFirst();
            bytes -= oldest.event.bytes().length;
            forget(oldest.frame());
        }
    }

    /** Returns all stored events, in order. */
    List<ServerMessage.Event> all() {
        return kept.stream().map(each -> each.event.message()).toList();
    }

    /** Returns the newest frame of which some events are not stored; -1 if none. */
    long lastForgotten() {
        return lastForgotten;
    }

    /** Records that some events of this frame or of earlier frames are not stored. */
    void forget(long frame) {
        lastForgotten = Math.max(lastForgotten, frame);
    }

    /**
     * Returns the events after a frame, in order, without encoding or copying. The first event is
     * {@code missed} if some of these events were discarded. It reports the loss, and the remaining
     * events of incomplete frames are omitted.
     *
     * @param encoding encoding of the event {@code missed}
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
