// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.View;
import reve.core.agent.protocol.Encoding;

import java.util.ArrayDeque;
import java.util.Deque;
import java.util.List;

/**
 * The queue of outgoing messages of one client. Messages keep their order, and their number and
 * size are limited. Events are counted separately, because other clients cause them. The events of
 * whole frames are dropped if too many events are waiting, and one message reports the loss. Only
 * the newest perception of a stream waits. It is encoded when it is written, as the difference from
 * the perception written before. Any thread may add messages; the event loop removes them.
 */
public final class Outbox {

    /** An entry of the queue, which waits to be written. */
    sealed interface Waiting {}

    /** An encoded message. */
    public record Message(byte[] bytes, boolean isEvent) implements Waiting {}

    /**
     * A report of dropped events. It contains their number, and the first and last frame whose
     * events were dropped.
     */
    record Missed(long events, long first, long last) implements Waiting {}

    /**
     * A perception, which is encoded when it is written.
     *
     * @param before the previous view of the client, from which the difference is computed; null
     *     for a full perception
     */
    record Perception(long id, View view, @Nullable View before) implements Waiting {}

    /**
     * Memory that an event takes in the queue [bytes]. Its encoded bytes are not included, because
     * clients share them.
     */
    private static final int EVENT_BYTES = 64;

    /** Memory of a reference to a shared event in a list [bytes]. */
    private static final int REFERENCE_BYTES = 8;

    private final int maxMessages;
    private final int maxBytes;
    private final Runnable filled;

    /**
     * Events from the time when the client had no connection. They are shared with other clients
     * and encoded when they are written. The limit on waiting events does not apply to them.
     */
    private List<HeardEvent.Told> history = List.of();

    private int historyWritten;
    private Encoding historyEncoding = Encoding.JSON;
    private byte @Nullable [] welcome;
    private final Deque<Waiting> messages = new ArrayDeque<>();
    private final Load answers = new Load();
    private final Load events = new Load();

    /** Number of the last frame whose events were added. */
    private long happenedIn = -1;

    /** Number of dropped events that are not reported yet; 0 if none. */
    private long missed;

    private long firstMissed;
    private long lastMissed;
    private @Nullable Perception answer;
    private @Nullable View latest;
    private long latestId;
    private @Nullable View told;
    private boolean finished;

    /** Number and size of waiting messages. */
    private static final class Load {
        private int count;
        private int bytes;

        void add(byte[] line, int times) {
            count += times;
            bytes += times * line.length;
        }

        void clear() {
            count = 0;
            bytes = 0;
        }
    }

    /**
     * @param filled called under this object's lock when there is new data to write
     */
    public Outbox(int maxMessages, int maxBytes, Runnable filled) {
        this.maxMessages = maxMessages;
        this.maxBytes = maxBytes;
        this.filled = filled;
    }

    /**
     * Queues the welcome of a session, and the events from the time when the client had no
     * connection. The limits do not apply to these.
     */
    public synchronized void begin(byte[] line, List<HeardEvent.Told> happened, Encoding encoding) {
        if (!finished) {
            welcome = line;
            history = happened;
            historyEncoding = encoding;
            filled.run();
        }
    }

    /**
     * Discards all waiting messages and accepts no more. Only {@code lastLine} is still written.
     */
    public synchronized void abandon(byte[] lastLine) {
        if (!finished) {
            finished = true;
            welcome = null;
            history = List.of();
            historyWritten = 0;
            messages.clear();
            answers.clear();
            events.clear();
            missed = 0;
            answer = null;
            latest = null;
            told = null;
            add(lastLine, false);
        }
    }

    /**
     * Adds a message that is not an event.
     *
     * @return false if too many messages are waiting
     */
    public synchronized boolean offer(byte[] line) {
        if (finished) {
            return true;
        }
        if (isFull(answers, line)) {
            return false;
        }
        add(line, false);
        return true;
    }

    /**
     * Adds an event of a frame, or drops the event if events are being dropped at present. Only
     * events of earlier frames count towards the limit, so the events of one frame are always kept
     * together.
     *
     * @return false if too many events are waiting; the caller must call {@link #miss}
     */
    public synchronized boolean offer(byte[] line, long frame) {
        if (finished) {
            return true;
        }
        if (missed > 0) {
            miss(frame);
            return true;
        }
        if (frame != happenedIn && events.count > 0 && isFull(events, line)) {
            return false;
        }
        happenedIn = frame;
        add(line, true);
        return true;
    }

    /**
     * Drops an event of a frame. Further events are also dropped until the waiting events are
     * written.
     */
    public synchronized void miss(long frame) {
        miss(1, frame, frame);
    }

    /**
     * Drops {@code count} events of the frames {@code first} to {@code last}, like {@link
     * #miss(long)}.
     */
    public synchronized void miss(long count, long first, long last) {
        if (!finished) {
            firstMissed = missed == 0 ? first : firstMissed;
            lastMissed = last;
            missed += count;
            if (events.count == 0) {
                tellMissed();
                filled.run();
            }
        }
    }

    private boolean isFull(Load load, byte[] line) {
        return load.count >= maxMessages || load.bytes + line.length > maxBytes;
    }

    private void tellMissed() {
        if (missed > 0) {
            messages.addLast(new Missed(missed, firstMissed, lastMissed));
            missed = 0;
        }
    }

    /**
     * Adds the answer to a single request for a perception. The previous answer must have been
     * written.
     */
    public synchronized void offerAnswer(long id, View view) {
        if (!finished) {
            answer = new Perception(id, view, null);
            filled.run();
        }
    }

    /** Adds the newest perception of the stream, which replaces a waiting one. */
    public synchronized void offerLatest(long id, View view) {
        if (!finished) {
            latest = view;
            latestId = id;
            filled.run();
        }
    }

    /**
     * Begins a new stream of perceptions. The first perception of the stream is complete, not a
     * difference.
     */
    public synchronized void restart() {
        latest = null;
        told = null;
    }

    /** Returns whether the answer to a single request for a perception is waiting. */
    public synchronized boolean hasAnswer() {
        return answer != null;
    }

    /**
     * Accepts no more messages. The waiting messages are still written, and {@code lastLine} after
     * them.
     */
    synchronized void finish(byte[] lastLine) {
        if (!finished) {
            finished = true;
            latest = null;
            tellMissed();
            if (answer != null) {
                messages.addLast(
                        // The answer comes after the events of all frames up to the frame of the
                        // perception.
                        answer);
                answer = null;
            }
            add(lastLine, false);
        }
    }

    /** Returns the next entry to write, and removes it; null if the queue is empty. */
    public synchronized @Nullable Waiting poll() {
        if (welcome != null) {
            var first = new Message(welcome, false);
            welcome = null;
            return first;
        }
        if (historyWritten < history.size()) {
            var next = new Message(history.get(historyWritten++).in(historyEncoding), false);
            if (historyWritten == history.size()) {
                history = List.of();
                historyWritten = 0;
            }
            return next;
        }
        Waiting next = messages.pollFirst();
        if (next instanceof Message message) {
            (message.isEvent ? events : answers).add(message.bytes, -1);
            if (events.count == 0) {
                tellMissed();
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

    /** Returns whether the queue is empty and accepts no more messages. */
    public synchronized boolean isDone() {
        return finished && isEmpty();
    }

    /** Returns whether the queue is empty. */
    public synchronized boolean isEmpty() {
        return welcome == null
                && history.isEmpty()
                && messages.isEmpty()
                && answer == null
                && latest == null;
    }

    /**
     * Returns the memory of the queue without perceptions [bytes]. An event counts only with its
     * entry in the queue, because clients share its encoded bytes.
     */
    public synchronized int bytes() {
        return answers.bytes
                + EVENT_BYTES * events.count
                + REFERENCE_BYTES * (history.size() - historyWritten);
    }

    private void add(byte[] line, boolean isEvent) {
        messages.addLast(new Message(line, isEvent));
        (isEvent ? events : answers).add(line, 1);
        filled.run();
    }
}
