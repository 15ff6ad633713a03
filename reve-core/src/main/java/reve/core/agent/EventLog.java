package reve.core.agent;

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
    private final Deque<Told> told = new ArrayDeque<>();
    private int bytes;
    private long lastForgotten = -1;

    private record Told(ServerMessage.Event event, int bytes, long nanos) {}

    EventLog(long maxNanos, int maxBytes) {
        this.maxNanos = maxNanos;
        this.maxBytes = maxBytes;
    }

    /** @param size of the event as it was told [bytes] */
    void add(ServerMessage.Event event, int size, long nowNanos) {
        told.addLast(new Told(event, size, nowNanos));
        bytes += size;
        while (bytes > maxBytes || nowNanos - told.getFirst().nanos > maxNanos) {
            Told oldest = told.removeFirst();
            bytes -= oldest.bytes;
            forget(oldest.event.frame());
        }
    }

    /** Of a frame, and of those before, not all is here. */
    void forget(long frame) {
        lastForgotten = Math.max(lastForgotten, frame);
    }

    /**
     * What happened after a frame, in order. If some of it is forgotten, an event {@code missed} is
     * the first, and what is left of the forgotten frames is not among the others.
     */
    List<ServerMessage.Event> after(long frame) {
        var events = new ArrayList<ServerMessage.Event>();
        if (lastForgotten > frame) {
            events.add(ServerMessage.Event.missed(OptionalLong.empty(), frame + 1, lastForgotten));
        }
        told.stream().map(Told::event)
                .filter(event -> event.frame() > Math.max(frame, lastForgotten))
                .forEach(events::add);
        return events;
    }
}
