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
 * What waits to be written to one client. Messages keep their order and are bounded. Events count
 * apart from the others, as they are what other clients do: those that exceed the bound are missed,
 * frame by frame, and one message says so. Of perceptions only the newest waits, and what is
 * different in it from the one before is worked out when it is written. Filled from any thread,
 * emptied by the event loop.
 */
public final class Outbox {

    /** What is written next. */
    sealed interface Waiting {}

    /** A message as it goes over the wire. */
    public record Message(byte[] bytes, boolean isEvent) implements Waiting {}

    /** So many events of these frames, and all of each frame, were not kept. */
    record Missed(long events, long first, long last) implements Waiting {}

    /**
     * What is perceived, encoded only when it is written.
     *
     * @param before what the client was handed last, to which the difference is told; null for all
     */
    record Perception(long id, View view, @Nullable View before) implements Waiting {}

    /** Memory of an event in the queue, without what it shares [bytes]. */
    private static final int EVENT_BYTES = 64;

    /** Memory of a shared event in a list [bytes]. */
    private static final int REFERENCE_BYTES = 8;

    private final int maxMessages;
    private final int maxBytes;
    private final Runnable filled;

    /**
     * What happened while a returning client was away, shared with others and encoded when it is
     * written; it may be more than may pile up.
     */
    private List<HeardEvent.Told> history = List.of();

    private int historyWritten;
    private Encoding historyEncoding = Encoding.JSON;
    private byte @Nullable [] welcome;
    private final Deque<Waiting> messages = new ArrayDeque<>();
    private final Load answers = new Load();
    private final Load events = new Load();

    /** The last frame of which events were added. */
    private long happenedIn = -1;

    /** Events that were not kept since {@link #events} was empty last; 0 if all were. */
    private long missed;

    private long firstMissed;
    private long lastMissed;
    private @Nullable Perception answer;
    private @Nullable View latest;
    private long latestId;
    private @Nullable View told;
    private boolean finished;

    /** How much waits. */
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
     * @param filled told, with this held, whenever there is something to write
     */
    public Outbox(int maxMessages, int maxBytes, Runnable filled) {
        this.maxMessages = maxMessages;
        this.maxBytes = maxBytes;
        this.filled = filled;
    }

    /**
     * Begins with the welcome of a client that goes on with its session, and with what happened
     * meanwhile. Nothing of it is left out.
     */
    public synchronized void begin(byte[] line, List<HeardEvent.Told> happened, Encoding encoding) {
        if (!finished) {
            welcome = line;
            history = happened;
            historyEncoding = encoding;
            filled.run();
        }
    }

    /** Discards what waits and takes nothing more; only this line is still written. */
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
     * Adds a message that is no event.
     *
     * @return false if the client has let too many of these pile up
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
     * Adds an event of a frame, or counts it as missed while the client misses events. However many
     * events a frame has, only what is left of earlier frames counts as piled up.
     *
     * @return false if too many have piled up; {@link #miss} is next
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
     * The client misses an event of a frame, and all that follow until it has been written what
     * waits.
     */
    public synchronized void miss(long frame) {
        miss(1, frame, frame);
    }

    /** The client misses so many events of these frames, as with {@link #miss(long)}. */
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

    /** Adds the perception that was asked for once; the one before has been written. */
    public synchronized void offerAnswer(long id, View view) {
        if (!finished) {
            answer = new Perception(id, view, null);
            filled.run();
        }
    }

    /** Puts the newest perception of the stream in the place of one that nobody has read. */
    public synchronized void offerLatest(long id, View view) {
        if (!finished) {
            latest = view;
            latestId = id;
            filled.run();
        }
    }

    /** A new stream of perceptions begins. */
    public synchronized void restart() {
        latest = null;
        told = null;
    }

    /** Returns true if a perception that was asked for once waits. */
    public synchronized boolean hasAnswer() {
        return answer != null;
    }

    /** Takes nothing more; what waits is written, then this line, then the writer ends. */
    synchronized void finish(byte[] lastLine) {
        if (!finished) {
            finished = true;
            latest = null;
            tellMissed();
            if (answer != null) {
                messages.addLast(answer); // behind what happened until the frame that it shows
                answer = null;
            }
            add(lastLine, false);
        }
    }

    /** Takes what is to be written next; null if nothing waits. */
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

    /** True when nothing waits, and nothing more will come. */
    public synchronized boolean isDone() {
        return finished && isEmpty();
    }

    /** Returns true if nothing waits. */
    public synchronized boolean isEmpty() {
        return welcome == null
                && history.isEmpty()
                && messages.isEmpty()
                && answer == null
                && latest == null;
    }

    /**
     * Returns how many bytes of memory what waits takes, besides perceptions. The bytes of events
     * are shared by all who are sent them, so an event counts for its place in the queue.
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
