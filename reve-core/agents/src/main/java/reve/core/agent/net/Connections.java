// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;

import java.io.Closeable;
import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.SocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.function.Supplier;

import javax.net.ssl.SSLEngine;

/**
 * The connections of a server: takes them in, has them written to and read again, and lets go of
 * them. The event loop's thread, but where said otherwise.
 */
public final class Connections {

    /** So that a flood of connections does not keep the others waiting. */
    private static final int ACCEPTED_PER_TURN = 16;

    /** Least time between two looks at clients that have sent all that they may. */
    private static final long THROTTLE_NANOS = 10_000_000;

    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Optional<Supplier<SSLEngine>> tls;
    private final Counters counters;
    private final RateLimitedLog log;

    /** Of its own, so that a flood of connections hides nothing that is said of agents. */
    private final RateLimitedLog strangersLog =
            new RateLimitedLog(1, "clients that have not said hello");

    private final Optional<AuditLog> audit;
    private final Door door;
    private final EventLoop loop;
    private final ServerSocketChannel listening;
    private final SelectionKey accepting;
    private final Set<Connection> open = new HashSet<>();
    private final PendingConnections<Connection> pending;
    private final Writers writers = new Writers(Runtime.getRuntime().availableProcessors());
    private final SlowReaders<Connection> slowReaders = new SlowReaders<>();

    /** They have sent all that they may. */
    private List<Connection> throttled = new ArrayList<>();

    private long readThrottledNanos = System.nanoTime();

    /**
     * @param tls makes the engine of each connection; without, they are plain text
     * @param log about clients that have said hello
     * @param audit records all that clients are sent
     * @param listening its connections are accepted
     */
    public Connections(
            AgentLimits limits,
            AgentTimeouts timeouts,
            Optional<Supplier<SSLEngine>> tls,
            Counters counters,
            RateLimitedLog log,
            Optional<AuditLog> audit,
            Door door,
            EventLoop loop,
            ServerSocketChannel listening)
            throws IOException {
        this.limits = limits;
        this.timeouts = timeouts;
        this.tls = tls;
        this.counters = counters;
        this.log = log;
        this.audit = audit;
        this.door = door;
        this.loop = loop;
        this.listening = listening;
        int all = limits.maxConnections();
        this.pending = new PendingConnections<>(all - all / 4);
        this.accepting = loop.register(listening, SelectionKey.OP_ACCEPT, key -> accept());
    }

    // ---- for the server ----

    /** Any thread. */
    public void start() {
        writers.start();
    }

    /** Stops the writers: nothing is written any more. Any thread. */
    public void stop() {
        writers.stop();
    }

    /** Returns true if a connection waits to be written to. Any thread. */
    public boolean isWaiting() {
        return writers.isWaiting();
    }

    /** Returns true if no connection is open. */
    public boolean isEmpty() {
        return open.isEmpty();
    }

    /** Accepts no more connections, and ends those that are open. */
    public void close(CloseReason why) {
        closeQuietly(listening);
        open.forEach(connection -> connection.end(why));
    }

    /** Writes what waits for clients, and cuts those that have been slow for the longest. */
    public void writeAll() {
        writers.writeAll();
        slowReaders.excess().forEach(Connection::giveUp);
    }

    /** Ends connections that take too long. Called every now and then. */
    public void checkDeadlines(long nowNanos) {
        List.copyOf(open).forEach(connection -> connection.checkDeadlines(nowNanos));
    }

    /** Accepts again after it failed. */
    public void acceptAgain() {
        if (accepting.isValid()) {
            accepting.interestOps(SelectionKey.OP_ACCEPT);
        }
    }

    /**
     * Reads clients again that have sent all that they may. Not in every turn: many a frame of a
     * fast world goes by before they may send much more.
     */
    public void readThrottled() {
        long now = System.nanoTime();
        if (throttled.isEmpty() || now - readThrottledNanos < THROTTLE_NANOS) {
            return;
        }
        readThrottledNanos = now;
        List<Connection> due = throttled;
        throttled = new ArrayList<>();
        due.forEach(Connection::readAgain);
    }

    // ---- for connections ----

    AgentLimits limits() {
        return limits;
    }

    AgentTimeouts timeouts() {
        return timeouts;
    }

    Counters counters() {
        return counters;
    }

    RateLimitedLog log() {
        return log;
    }

    /** About connections that have not said hello. */
    RateLimitedLog strangersLog() {
        return strangersLog;
    }

    Optional<AuditLog> audit() {
        return audit;
    }

    Door door() {
        return door;
    }

    EventLoop loop() {
        return loop;
    }

    /** Returns what the event loop writes with. */
    WriteBuffers buffers() {
        return writers.buffers();
    }

    /** Returns the connections that do not read what was written to them. */
    public SlowReaders<Connection> slowReaders() {
        return slowReaders;
    }

    /** Has what waits for a client written in this turn. Any thread. */
    void writeSoon(Connection connection) {
        writers.add(connection);
        loop.wake();
    }

    /** Has it read again in a while: with news, which a frame is, or when deadlines are checked. */
    void readLater(Connection connection) {
        throttled.add(connection);
    }

    /** It has said hello. */
    void known(Connection connection) {
        pending.remove(connection.address(), connection);
    }

    void forget(Connection connection) {
        known(connection);
        if (open.remove(connection)) {
            counters.open.decrement();
        }
    }

    // ---- accepting ----

    private void accept() {
        try {
            for (int i = 0; i < ACCEPTED_PER_TURN; i++) {
                SocketChannel accepted = listening.accept();
                if (accepted == null) {
                    return;
                }
                admit(accepted);
            }
        } catch (IOException e) { // out of descriptors: wait for some to come free
            log.error("accepting a connection failed", e);
            accepting.interestOps(0);
        }
    }

    private void admit(SocketChannel channel) {
        counters.connections.increment();
        if (open.size() >= limits.maxConnections()) {
            turnAway(channel, CloseReason.serverFull(limits.maxConnections()));
            return;
        }
        try {
            var client = (InetSocketAddress) channel.getRemoteAddress();
            if (!pending.haveRoomFor(client.getAddress())) {
                turnAway(
                        channel,
                        CloseReason.cut(
                                "too-many-connections",
                                "too many connections from your address have not said hello"));
                return;
            }
            var connection = new Connection(this, wire(channel));
            open.add(connection);
            pending.add(connection.address(), connection);
            counters.open.increment();
        } catch (IOException e) {
            closeQuietly(channel); // it has gone by itself
        }
    }

    private Wire wire(SocketChannel channel) {
        return tls.isEmpty() ? Wire.of(channel) : new TlsWire(channel, tls.get().get());
    }

    private void turnAway(SocketChannel channel, CloseReason why) {
        counters.cut.increment();
        try (channel) {
            SocketAddress client = channel.getRemoteAddress();
            strangersLog.warn(
                    () -> "a client at " + client + " was turned away: " + why.getMessage());
            channel.configureBlocking(false);
            if (tls.isEmpty()) { // else it would take a handshake
                channel.write(ByteBuffer.wrap(why.bye().in(Encoding.JSON)));
            }
            channel.shutdownOutput();
        } catch (IOException e) {
            // It has gone by itself.
        }
    }

    private static void closeQuietly(Closeable resource) {
        try {
            resource.close();
        } catch (IOException e) {
            // Closing frees the descriptor even when it complains.
        }
    }
}
