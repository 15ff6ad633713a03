package reve.core.agent;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.List;
import org.jspecify.annotations.Nullable;

/**
 * What waits to be written to one client. Messages keep their order and are bounded; of perceptions
 * only the newest waits, and what is different in it from the one before is worked out when it is
 * written. Filled from any thread, emptied by the event loop.
 */
final class Outbox {

    /** What is written next. */
    sealed interface Waiting {}

    /** A message as it goes over the wire. */
    record Message(byte[] bytes) implements Waiting {}

    /**
     * What is perceived, encoded only when it is written.
     *
     * @param before what the client was handed last, to which the difference is told; null for all
     */
    record Perception(long id, View view, @Nullable View before) implements Waiting {}

    private final int maxMessages;
    private final int maxBytes;
    private final Runnable filled;
    /** What a returning client has missed; it may be more than may pile up. */
    private final Deque<Message> missed = new ArrayDeque<>();
    private final Deque<Waiting> messages = new ArrayDeque<>();
    private int bytes;
    /**
     * Of the last frame that anything happened in: what waits of it is nobody's fault
     * before the next one.
     */
    private long happenedIn = -1;
    private int happened;
    private int happenedBytes;
    private @Nullable Perception answer;
    private @Nullable View latest;
    private long latestId;
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
            lines.forEach(line -> missed.addLast(new Message(line)));
            filled.run();
        }
    }

    /** Adds a message. @return false if the client has let too many pile up */
    synchronized boolean offer(byte[] line) {
        if (finished) {
            return true;
        }
        if (isFull(happened, happenedBytes, line)) {
            return false;
        }
        add(line);
        return true;
    }

    /**
     * Adds what happened in a frame. However much that is, only what is left of earlier frames
     * counts as piled up.
     *
     * @return false if the client has let too much pile up
     */
    synchronized boolean offer(byte[] line, long frame) {
        if (finished) {
            return true;
        }
        if (frame != happenedIn) {
            if (isFull(0, 0, line)) {
                return false;
            }
            happenedIn = frame;
            happened = 0;
            happenedBytes = 0;
        }
        happened++;
        happenedBytes += line.length;
        add(line);
        return true;
    }

    private boolean isFull(int excusedMessages, int excusedBytes, byte[] line) {
        return messages.size() - excusedMessages >= maxMessages
                || bytes - excusedBytes + line.length > maxBytes;
    }

    /** Adds the perception that was asked for once; the one before has been written. */
    synchronized void offerAnswer(long id, View view) {
        if (!finished) {
            answer = new Perception(id, view, null);
            filled.run();
        }
    }

    /** Puts the newest perception of the stream in the place of one that nobody has read. */
    synchronized void offerLatest(long id, View view) {
        if (!finished) {
            latest = view;
            latestId = id;
            filled.run();
        }
    }

    /** A new stream of perceptions begins. */
    synchronized void restart() {
        latest = null;
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
                messages.addLast(answer); // behind what happened until the frame that it shows
                answer = null;
            }
            add(lastLine);
        }
    }

    /** Takes what is to be written next; null if nothing waits. */
    synchronized @Nullable Waiting poll() {
        if (!missed.isEmpty()) {
            return missed.removeFirst();
        }
        Waiting next = messages.pollFirst();
        if (next instanceof Message message) {
            bytes -= message.bytes.length;
            if (messages.isEmpty()) {
                happened = 0;
                happenedBytes = 0;
            }
        } else if (next == null && answer != null) {
            next = answer;
            answer = null;
        } else if (next == null && latest != null) {
            next = new Perception(latestId, latest, told);
            told = latest;
            latest = null;
        }
        return next;
    }

    /** True when nothing waits, and nothing more will come. */
    synchronized boolean isDone() {
        return finished && isEmpty();
    }

    synchronized boolean isEmpty() {
        return missed.isEmpty() && messages.isEmpty() && answer == null && latest == null;
    }

    private void add(byte[] line) {
        messages.addLast(new Message(line));
        bytes += line.length;
        filled.run();
    }
}
