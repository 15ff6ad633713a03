package reve.core.agent;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.List;
import java.util.Optional;

/**
 * The last events that a client was told, so that one whose connection broke gets those it missed. Bounded in
 * number and bytes. Guarded by its session.
 */
final class EventLog {

    private final int maxEvents;
    private final int maxBytes;
    private final Deque<Told> told = new ArrayDeque<>();
    private int bytes;
    private long lastForgotten = -1;

    private record Told(long frame, byte[] line) {}

    EventLog(int maxEvents, int maxBytes) {
        this.maxEvents = maxEvents;
        this.maxBytes = maxBytes;
    }

    void add(long frame, byte[] line) {
        told.addLast(new Told(frame, line));
        bytes += line.length;
        while (told.size() > maxEvents || bytes > maxBytes) {
            Told oldest = told.removeFirst();
            bytes -= oldest.line.length;
            lastForgotten = oldest.frame;
        }
    }

    /** What happened after a frame, in order; empty if some of it is forgotten. */
    Optional<List<byte[]>> after(long frame) {
        return lastForgotten > frame ? Optional.empty()
                : Optional.of(told.stream().filter(event -> event.frame > frame).map(Told::line).toList());
    }
}
