package reve.core.agent;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.List;
import org.jspecify.annotations.Nullable;

/**
 * What waits to be written to one client. Messages keep their order and are bounded; of perceptions only the
 * newest waits. Filled from any thread, emptied by the event loop.
 */
final class Outbox {

    private static final byte[] NOTHING = {};

    /** One line in two parts, so that everybody shares the long one. */
    record Line(byte[] head, byte[] tail) {

        int bytes() {
            return head.length + tail.length;
        }
    }

    private final int maxMessages;
    private final int maxBytes;
    private final Runnable filled;
    /** What a returning client has missed; it may be more than may pile up. */
    private final Deque<Line> missed = new ArrayDeque<>();
    private final Deque<Line> messages = new ArrayDeque<>();
    private int bytes;
    private @Nullable Line answer;
    private @Nullable Line latest;
    private @Nullable View latestView;
    private @Nullable View told;
    private boolean finished;

    /** @param filled told, with this held, whenever there is something to write */
    Outbox(int maxMessages, int maxBytes, Runnable filled) {
        this.maxMessages = maxMessages;
        this.maxBytes = maxBytes;
        this.filled = filled;
    }

    /** What a client is told first that goes on with its session. Nothing of it is left out. */
    synchronized void begin(List<byte[]> lines) {
        if (!finished) {
            lines.forEach(line -> missed.addLast(new Line(line, NOTHING)));
            filled.run();
        }
    }

    /** Adds a message. @return false if the client has let too many pile up */
    synchronized boolean offer(byte[] line) {
        if (finished) {
            return true;
        }
        if (messages.size() >= maxMessages || bytes + line.length > maxBytes) {
            return false;
        }
        add(new Line(line, NOTHING));
        return true;
    }

    /** Adds the perception that was asked for once; the one before has been written. */
    synchronized void offerAnswer(Line perception) {
        if (!finished) {
            answer = perception;
            filled.run();
        }
    }

    /** What the last perception of the stream that the client was handed showed; null before the first. */
    synchronized @Nullable View told() {
        return told;
    }

    /**
     * Puts the newest perception in the place of one that nobody has read.
     *
     * @param base what it tells the difference to, null if it tells all
     * @return false if the client was handed another one meanwhile
     */
    synchronized boolean offerLatest(Line perception, View view, @Nullable View base) {
        if (finished) {
            return true;
        }
        if (told != base) {
            return false;
        }
        latest = perception;
        latestView = view;
        filled.run();
        return true;
    }

    /** A new stream of perceptions begins. */
    synchronized void restart() {
        latest = null;
        latestView = null;
        told = null;
    }

    synchronized boolean hasAnswer() {
        return answer != null;
    }

    /** Takes nothing more; what waits is written, then this line, then the writer ends. */
    synchronized void finish(byte[] lastLine) {
        if (!finished) {
            finished = true;
            latest = null;
            if (answer != null) {
                add(answer); // behind what happened until the frame that it shows
                answer = null;
            }
            add(new Line(lastLine, NOTHING));
        }
    }

    /** The next line to write, if it is no longer than that; else null. */
    synchronized @Nullable Line poll(int maxLength) {
        Line line = next();
        if (line == null || line.bytes() > maxLength) {
            return null;
        }
        if (!missed.isEmpty()) {
            missed.removeFirst();
        } else if (!messages.isEmpty()) {
            messages.removeFirst();
            bytes -= line.bytes();
        } else if (answer != null) {
            answer = null;
        } else {
            latest = null;
            told = latestView;
        }
        return line;
    }

    private @Nullable Line next() {
        return !missed.isEmpty() ? missed.getFirst() : !messages.isEmpty() ? messages.getFirst() : answer != null ? answer : latest;
    }

    /** True when nothing waits, and nothing more will come. */
    synchronized boolean isDone() {
        return finished && isEmpty();
    }

    synchronized boolean isEmpty() {
        return next() == null;
    }

    private void add(Line line) {
        messages.addLast(line);
        bytes += line.bytes();
        filled.run();
    }
}
