// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.net.Connection;
import reve.core.agent.net.Outbox;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.publish.PerceptionRequests;

import java.util.List;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.function.Function;

/**
 * The outgoing messages of a session. They are sent to its current connection, or to a later
 * connection that resumes the session. For any thread, unless stated otherwise. Lock order: the
 * lock of the session before the lock of this object.
 */
final class SessionOutput {
    private final Function<Optional<Connection>, PerceptionRequests> requestsOver;

    /**
     * Recent events, for a connection that resumes the session; null if the session cannot be
     * resumed. Guarded by this object's lock.
     */
    private final @Nullable EventLog events;

    /** The newest frame in which a command took effect. Guarded by this object's lock. */
    private long lastResultFrame;

    /** The current connection; null while it is broken. Changed under the lock of this object. */
    private volatile @Nullable Connection connection;

    private volatile Encoding encoding;
    private volatile PerceptionRequests perceptions;
    private volatile long joinedInFrame;

    /**
     * @param connection empty for a session that waits for its first connection to this server
     * @param keptNanos how long events are kept for a connection that resumes the session [ns]; 0
     *     if the session cannot be resumed
     * @param requestsOver creates the object with the requests of the client over a connection
     */
    SessionOutput(
            Optional<Connection> connection,
            long keptNanos,
            Function<Optional<Connection>, PerceptionRequests> requestsOver) {
        this.connection = connection.orElse(null);
        this.encoding = connection.map(Connection::encoding).orElse(Encoding.JSON);
        this.requestsOver = requestsOver;
        this.perceptions = requestsOver.apply(connection);
        this.events = keptNanos == 0 ? null : new EventLog(keptNanos, EventLog.MAX_BYTES);
    }

    Encoding encoding() {
        return encoding;
    }

    PerceptionRequests perceptions() {
        return perceptions;
    }

    /** Records the first frame whose events the client receives. */
    void beginAt(long frame) {
        joinedInFrame = frame;
        perceptions.notBefore(frame);
    }

    /**
     * Adds what another server knew about the session.
     *
     * @param next first frame whose events the client receives from this server
     */
    synchronized void restore(
            long next, long resultFrame, List<ServerMessage.Event> sent, long forgotten) {
        joinedInFrame = next;
        lastResultFrame = resultFrame;
        EventLog kept = events;
        if (kept != null) {
            long now = System.nanoTime();
            sent.forEach(event -> kept.add(HeardEvent.Told.of(event, encoding), now));
            kept.forget(forgotten);
        }
    }

    /** Returns the newest frame in which a command took effect. */
    synchronized long lastResultFrame() {
        return lastResultFrame;
    }

    /** Returns the recent events; empty if the session cannot be resumed. */
    synchronized List<ServerMessage.Event> events() {
        EventLog kept = events;
        return kept == null ? List.of() : kept.all();
    }

    /** Returns the newest frame of which recent events are missing; -1 if none. */
    synchronized long lastForgotten() {
        EventLog kept = events;
        return kept == null ? -1 : kept.lastForgotten();
    }

    /** Returns whether this queue belongs to the current connection. */
    synchronized boolean isSentBy(Outbox outbox) {
        Connection now = connection;
        return now != null && now.outbox() == outbox;
    }

    boolean isBroken() {
        return connection == null;
    }

    synchronized void breakOff() {
        connection = null;
    }

    /**
     * Makes another connection the current one.
     *
     * @return the former connection; null if it is broken
     */
    synchronized @Nullable Connection switchTo(Connection next) {
        Connection previous = connection;
        connection = next;
        encoding = next.encoding();
        perceptions = requestsOver.apply(Optional.of(next));
        perceptions.notBefore(lastResultFrame);
        return previous;
    }

    /**
     * Notifies the relay of the current connection about the client, before the client's welcome is
     * sent.
     */
    void welcomed(Role role, String world, String client) {
        Connection now = connection;
        if (now != null) {
            now.welcomed(role, world, client);
        }
    }

    /**
     * Queues a welcome and the events after a frame. They are the first messages of the current
     * connection.
     */
    synchronized void begin(ServerMessage welcome, long frameSeen) {
        Connection now = connection;
        EventLog kept = events;
        if (now != null && kept != null) {
            now.outbox().begin(welcome.in(encoding), kept.after(frameSeen, encoding), encoding);
        }
    }

    /**
     * Queues a message.
     *
     * @return false if too many messages are waiting
     */
    boolean offer(ServerMessage message) {
        return offer(message.in(encoding));
    }

    /**
     * Queues an encoded message.
     *
     * @return false if too many messages are waiting
     */
    boolean offer(byte[] line) {
        Connection now = connection;
        return now == null || now.outbox().offer(line);
    }

    /**
     * Queues the result of a command that took effect in a frame. Perceptions sent after it are not
     * older than that frame.
     *
     * @return false if too many messages are waiting
     */
    synchronized boolean offerResult(ServerMessage result, long frame) {
        lastResultFrame = Math.max(lastResultFrame, frame);
        perceptions.notBefore(lastResultFrame);
        return offer(result);
    }

    /** Sends a message; ends the connection if too many messages are waiting. */
    void send(ServerMessage message) {
        Connection now = connection;
        if (now != null) {
            now.send(message);
        }
    }

    /** Measures the round-trip time to the client, see {@link Connection#measureRoundTrip}. */
    void measureRoundTrip() {
        Connection now = connection;
        if (now != null) {
            now.measureRoundTrip();
        }
    }

    /** Returns the last round-trip time over the current connection [s]; empty if there is none. */
    OptionalDouble roundTripSeconds() {
        Connection now = connection;
        return now == null ? OptionalDouble.empty() : now.roundTripSeconds();
    }

    /** Ends the current connection. */
    void end(CloseReason why) {
        Connection now = connection;
        if (now != null) {
            now.end(why);
        }
    }

    /** Sends an event. For the event loop's thread only. */
    void tell(HeardEvent.Told event) {
        long frame = event.message().frame();
        if (frame < joinedInFrame) {
            return;
        }
        if (events != null) {
            synchronized (this) {
                events.add(event, System.nanoTime());
            }
        }
        Connection now = connection;
        if (now != null && !now.outbox().offer(event.bytes(), frame)) {
            // Writes at once, because frames may follow each other faster than the event loop
            // writes.
            now.write();
            if (!now.outbox().offer(event.bytes(), frame)) {
                now.outbox().miss(frame);
            }
        }
    }

    /**
     * Records that up to {@code count} events of the frames {@code first} to {@code last} are not
     * sent. For the event loop's thread.
     */
    void miss(long count, long first, long last) {
        if (last < joinedInFrame) {
            return;
        }
        if (events != null) {
            synchronized (this) {
                events.forget(last);
            }
        }
        Connection now = connection;
        if (now != null) {
            now.outbox().miss(count, Math.max(first, joinedInFrame), last);
        }
    }
}
