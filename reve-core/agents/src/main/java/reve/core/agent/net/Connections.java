// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Relay;
import reve.core.disk.Reason;

import java.io.Closeable;
import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.SocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.Executor;
import java.util.concurrent.ExecutorService;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.SynchronousQueue;
import java.util.concurrent.ThreadPoolExecutor;
import java.util.concurrent.TimeUnit;
import java.util.function.Supplier;

import javax.net.ssl.SSLEngine;

/**
 * The connections of a server: accepts them, schedules their reads and writes, and closes them. For
 * the event loop's thread, except where stated.
 */
public final class Connections {

    /**
     * Maximum number of connections accepted in one turn of the event loop, so that a flood of
     * connections does not delay other clients.
     */
    private static final int ACCEPTED_PER_TURN = 16;

    /**
     * Maximum number of waiting clients that are processed in one turn. A processed client joins,
     * or is removed because it has disconnected.
     */
    private static final int JOINS_PER_TURN = 256;

    /** Number of threads that compute TLS handshakes. */
    private static final int HANDSHAKE_THREADS =
            Math.max(1, Runtime.getRuntime().availableProcessors() / 2);

    /** Time after which a thread that has no command ends [s]. */
    private static final long IDLE_SECONDS = 10;

    /** Minimum time between two attempts to read from clients that have used up their quota. */
    private static final long THROTTLE_NANOS = ReadShares.WINDOW_NANOS;

    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Optional<Supplier<SSLEngine>> tls;
    private final Counters counters;
    private final RateLimitedLog log;

    /**
     * Log for connections that have sent no hello. The log is separate from the log for agents, so
     * that a flood of connections does not suppress lines about agents.
     */
    private final RateLimitedLog strangersLog =
            new RateLimitedLog(1, "clients that have not said hello");

    private final Optional<AuditLog> audit;
    private final Door door;
    private final EventLoop loop;
    private final Descriptors descriptors;
    private final ServerSocketChannel listening;

    /**
     * Runs the computations of TLS handshakes. The number of threads is small, so that a flood of
     * handshakes leaves the other processors to the worlds.
     */
    private final ExecutorService handshakes =
            threads("tls", HANDSHAKE_THREADS, HANDSHAKE_THREADS, new LinkedBlockingQueue<>());

    /** Runs the commands of control clients and queries: at most one for each connection. */
    private final ExecutorService commands =
            threads("agent control", 0, Integer.MAX_VALUE, new SynchronousQueue<>());

    /** Maximum number of open connections. */
    private final int most;

    /**
     * True after accepting a connection has failed, until it succeeds again. A failure is logged
     * only when this value changes to true.
     */
    private boolean isAcceptFailing;

    private final SelectionKey accepting;
    private final Set<Connection> open = new HashSet<>();
    private final PendingConnections<Connection> pending;
    private final Writers writers = new Writers(Runtime.getRuntime().availableProcessors());
    private final SlowReaders<Connection> slowReaders = new SlowReaders<>();

    private final ReadShares shares = new ReadShares();
    private final Hellos hellos;

    /** Connections of clients whose first message waits, because the limit on joins is reached. */
    private final Deque<Connection> joining = new ArrayDeque<>();

    /** Connections that have used up their quota, or wait for their share of the loop's time. */
    private List<Connection> throttled = new ArrayList<>();

    private long readThrottledNanos = System.nanoTime();

    /**
     * @param tls creates the TLS engine of each connection; if empty, connections are plain text
     * @param log receives lines about clients that have sent hello
     * @param audit records all messages to clients
     * @param descriptors the file descriptors that connections may take
     * @param listening the server socket
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
            Descriptors descriptors,
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
        this.descriptors = descriptors;
        this.listening = listening;
        this.most = (int) Math.min(limits.maxConnections(), descriptors.room());
        this.hellos = new Hellos(limits.hellos(), System.nanoTime());
        this.pending = new PendingConnections<>(most - most / 4);
        if (most < limits.maxConnections()) {
            log.warn(
                    "the process may open "
                            + descriptors.limit()
                            + " files, enough for "
                            + most
                            + " connections instead of "
                            + limits.maxConnections()
                            + "; raise the limit (ulimit -n) for more");
        }
        this.accepting = loop.register(listening, SelectionKey.OP_ACCEPT, key -> accept());
    }

    /** Starts the threads that write. For any thread. */
    public void start() {
        writers.start();
    }

    /** Stops the threads that write, and starts no further command. For any thread. */
    public void stop() {
        writers.stop();
        handshakes.shutdown();
        commands.shutdown();
    }

    /** Returns whether a connection has data to write. For any thread. */
    public boolean isWaiting() {
        return writers.isWaiting();
    }

    /** Returns whether no connection is open. */
    public boolean isEmpty() {
        return open.isEmpty();
    }

    /** Stops accepting, and ends all open connections. */
    public void close(CloseReason why) {
        closeQuietly(listening);
        open.forEach(connection -> connection.end(why));
    }

    /**
     * Writes the waiting messages of all connections, and disconnects the slowest clients if too
     * much data is waiting.
     */
    public void writeAll() {
        writers.writeAll();
        slowReaders.excess().forEach(Connection::giveUp);
    }

    /** Ends connections that exceed time limits. Called periodically. */
    public void checkDeadlines(long nowNanos) {
        descriptors.count();
        List.copyOf(open).forEach(connection -> connection.checkDeadlines(nowNanos));
    }

    /** Accepts connections again after a failure. */
    public void acceptAgain() {
        if (accepting.isValid()) {
            accepting.interestOps(SelectionKey.OP_ACCEPT);
        }
    }

    /**
     * Lets waiting clients join. Resumes reading from clients that had used up their quota, at most
     * once per {@link #THROTTLE_NANOS}, because a fast world makes many frames before the quota
     * grows.
     */
    public void readThrottled() {
        long now = System.nanoTime();
        for (int i = 0; i < JOINS_PER_TURN && !joining.isEmpty() && hellos.haveLeft(now); i++) {
            joining.remove().join();
        }
        if (throttled.isEmpty() || now - readThrottledNanos < THROTTLE_NANOS) {
            return;
        }
        readThrottledNanos = now;
        List<Connection> due = throttled;
        throttled = new ArrayList<>();
        int next = 0;
        while (next < due.size() && shares.hasLeft(now)) {
            due.get(next++).readAgain();
        }
        throttled.addAll(0, due.subList(next, due.size())); // the next window begins with these
    }

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

    /** Returns the log for connections that have not sent hello. */
    RateLimitedLog strangersLog() {
        return strangersLog;
    }

    Optional<AuditLog> audit() {
        return audit;
    }

    /** Returns the threads that run commands of control clients and queries. */
    Executor commands() {
        return commands;
    }

    Door door() {
        return door;
    }

    EventLoop loop() {
        return loop;
    }

    /** Returns the buffers of the event loop's thread. */
    WriteBuffers buffers() {
        return writers.buffers();
    }

    /** Returns the connections' shares of the event loop's time for decoding messages. */
    ReadShares shares() {
        return shares;
    }

    /** Returns whether a client may join now, and counts it if so. */
    boolean mayJoin() {
        if (!joining.isEmpty() || !hellos.haveLeft(System.nanoTime())) {
            return false;
        }
        hellos.count();
        return true;
    }

    /**
     * Queues a client that cannot join yet, because the limit on joins is reached. Clients join in
     * the order of these calls.
     */
    void joinLater(Connection connection) {
        joining.add(connection);
    }

    /** Counts a client that waited and now joins. */
    void countJoin() {
        hellos.count();
    }

    /** Returns the connections whose clients read too slowly. */
    public SlowReaders<Connection> slowReaders() {
        return slowReaders;
    }

    /** Schedules the connection for writing in this turn. For any thread. */
    void writeSoon(Connection connection) {
        writers.add(connection);
        loop.wake();
    }

    /**
     * Schedules a later attempt to read: when a frame is published, or when deadlines are checked.
     */
    void readLater(Connection connection) {
        throttled.add(connection);
    }

    /** Removes the connection from those without hello, because its hello has arrived. */
    void known(Connection connection) {
        pending.remove(connection.address(), connection);
    }

    void forget(Connection connection) {
        known(connection);
        if (open.remove(connection)) {
            counters.open.decrement();
            descriptors.give();
        }
    }

    /**
     * Creates daemon platform threads. Virtual threads are not suitable, because they share a few
     * carrier threads. A virtual thread that wakes the event loop may wait for a carrier thread,
     * and a world's thread that also wakes the loop would then wait for it. Tasks after {@link
     * #stop} are dropped.
     */
    private static ExecutorService threads(
            String name, int least, int most, BlockingQueue<Runnable> waiting) {
        return new ThreadPoolExecutor(
                least,
                most,
                IDLE_SECONDS,
                TimeUnit.SECONDS,
                waiting,
                Thread.ofPlatform().name(name).daemon().factory(),
                new ThreadPoolExecutor.DiscardPolicy());
    }

    private void accept() {
        try {
            for (int i = 0; i < ACCEPTED_PER_TURN; i++) {
                SocketChannel accepted = listening.accept();
                if (accepted == null) {
                    return;
                }
                isAcceptFailing = false;
                admit(accepted);
            }
        } catch (IOException e) {
            // No file descriptor is free. The server accepts again when some descriptors are
            // closed.
            if (!isAcceptFailing) {
                strangersLog.warn(
                        "no connection can be accepted: "
                                + Reason.of(e)
                                + "; see the limit of open files (ulimit -n)");
            }
            isAcceptFailing = true;
            accepting.interestOps(0);
        }
    }

    private void admit(SocketChannel channel) {
        try {
            admit(channel, (InetSocketAddress) channel.getRemoteAddress(), tls, null);
        } catch (IOException e) {
            closeQuietly(channel); // the peer has closed already
        }
    }

    /**
     * Adds the connection of a client that another server of this process has accepted and
     * decrypted.
     *
     * @param channel the server's end of a connection within this process
     * @param client address of the client
     * @param relay is notified when the session begins and when the connection ends
     */
    public void admit(SocketChannel channel, InetSocketAddress client, Relay relay) {
        admit(channel, client, Optional.empty(), relay);
    }

    /** Logs that no file descriptor is left; returns an exception for it. For any thread. */
    public IOException noDescriptors() {
        var none =
                new IOException(
                        "the process may open "
                                + descriptors.limit()
                                + " files, of which only the reserve for stores and records is"
                                + " left; raise the limit (ulimit -n)");
        strangersLog.warn(() -> "a client was turned away: " + none.getMessage());
        return none;
    }

    private void admit(
            SocketChannel channel,
            InetSocketAddress client,
            Optional<Supplier<SSLEngine>> encryption,
            @Nullable Relay relay) {
        counters.connections.increment();
        if (open.size() >= most || descriptors.room() <= 0) {
            turnAway(channel, client, encryption.isEmpty(), CloseReason.serverFull(open.size()));
            return;
        }
        try {
            if (!pending.haveRoomFor(client.getAddress())) {
                turnAway(
                        channel,
                        client,
                        encryption.isEmpty(),
                        CloseReason.cut(
                                "too-many-connections",
                                "too many connections from your address have not said hello"));
                return;
            }
            Wire wire =
                    encryption.isEmpty()
                            ? Wire.of(channel, client)
                            : new TlsWire(channel, client, encryption.get().get(), handshakes);
            var connection = new Connection(this, wire, relay);
            open.add(connection);
            descriptors.take();
            pending.add(connection.address(), connection);
            counters.open.increment();
        } catch (IOException e) {
            closeQuietly(channel); // the peer has closed already
        }
    }

    private void turnAway(
            SocketChannel channel, SocketAddress client, boolean plain, CloseReason why) {
        counters.cut.increment();
        try (channel) {
            strangersLog.warn(
                    () -> "a client at " + client + " was turned away: " + why.getMessage());
            channel.configureBlocking(false);
            if (plain) {
                // The refusal is plain text, because TLS would first need a handshake.
                channel.write(ByteBuffer.wrap(why.bye().in(Encoding.JSON)));
            }
            channel.shutdownOutput();
        } catch (IOException e) {
            // The exception is ignored, because the client has already closed the connection.
        }
    }

    private static void closeQuietly(Closeable resource) {
        try {
            resource.close();
        } catch (IOException e) {
            // The exception is ignored, because the operating system frees the file descriptor even
            // if close() fails.
        }
    }
}
