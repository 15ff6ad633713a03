// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.MessageReader;
import reve.core.agent.protocol.ServerMessage;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.charset.StandardCharsets;
import java.util.regex.Pattern;

import javax.net.ssl.SSLException;

/**
 * Reader of the messages of one connection. It passes the messages to the session within the
 * client's quota. It discards further input after the connection has ended. For the event loop's
 * thread only.
 */
final class ConnectionReader {

    private static final int MAX_DRAINED_BYTES = 1024 * 1024;
    private static final Pattern HTTP = Pattern.compile("^[A-Z]{3,10} .* HTTP/");

    private final Connections connections;
    private final Connection connection;
    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Counters counters;
    private final Wire wire;
    private final SelectionKey key;
    private final MessageFramer messages;
    private final ReadShares.Share share;

    /**
     * A message that waits for one of two events: the connection has a share of the event loop's
     * time again, or the client may join. Null if no message waits.
     */
    private @Nullable ByteBuffer waiting;

    private int errors;

    /**
     * True if the client has passed the limit on joins, so that its first message may be processed.
     */
    private boolean mayJoin;

    /** True while reading is suspended. */
    private boolean held;

    /**
     * Start of the period in which the client has sent more than its quota without a pause [ns]; 0
     * if the client is within its quota.
     */
    private long floodingSinceNanos;

    private int drained;

    ConnectionReader(Connections connections, Connection connection, Wire wire, SelectionKey key) {
        this.connections = connections;
        this.connection = connection;
        this.limits = connections.limits();
        this.timeouts = connections.timeouts();
        this.counters = connections.counters();
        this.wire = wire;
        this.key = key;
        this.share = connections.shares().open(System.nanoTime());
        this.messages = new MessageFramer(limits, timeouts, connection::ping);
    }

    /**
     * Checks the time since the client began to send its current message.
     *
     * @throws CloseReason if the client takes too long
     */
    void checkTime(long nowNanos) throws CloseReason {
        if (!held) {
            messages.checkTime(nowNanos);
        }
    }

    /** Reads the data that has arrived, and handles each complete message. */
    void read() {
        guard(
                () -> {
                    if (connection.hasEnded()) {
                        drain();
                        return;
                    }
                    if (held) {
                        pause(); // TLS must first write its own data
                        return;
                    }
                    do {
                        boolean open = messages.fill(wire);
                        takeAll();
                        if (!open) {
                            throw CloseReason.regular(
                                    "lost", "the client closed the connection without a bye");
                        }
                    } while (wire.hasReceived() && !held && !connection.hasEnded());
                });
    }

    private interface Reading {
        void read() throws IOException, CloseReason;
    }

    /** Runs code that reads messages. Ends the connection with a reason if the code fails. */
    private void guard(Reading reading) {
        try {
            reading.read();
        } catch (CloseReason e) {
            connection.end(e);
        } catch (TlsWire.PlainTextException e) {
            connection.end(
                    CloseReason.refused(
                            "tls-expected", "this server speaks TLS", "connect with TLS"));
        } catch (SSLException e) {
            connection.end(CloseReason.cut("tls-failed", "TLS failed: " + e.getMessage()));
            connection.close();
        } catch (IOException e) {
            connection.close();
        } catch (Throwable e) {
            connection.fail(e);
        }
    }

    private void takeAll() throws CloseReason {
        while (!connection.hasEnded() && !held) {
            Client client = connection.session();
            if (client != null && !client.hasQuota()) {
                throttle();
                return;
            }
            ByteBuffer next = waiting != null ? waiting : messages.next();
            if (next == null) {
                floodingSinceNanos = messages.hasTakenAll() ? 0 : floodingSinceNanos;
                return;
            }
            if (!mayJoin && !connections.mayJoin()) {
                waiting = copy(next);
                pause();
                connections.joinLater(connection);
                return;
            }
            mayJoin = true;
            if (!connections.shares().take(share, next.remaining(), System.nanoTime())) {
                waiting = waiting != null ? next : copy(next);
                pause();
                connections.readLater(connection);
                return;
            }
            waiting = null;
            counters.lines.increment();
            if (client != null) {
                client.count();
            }
            take(next);
        }
    }

    private static ByteBuffer copy(ByteBuffer message) {
        return ByteBuffer.allocate(message.remaining()).put(message).flip();
    }

    /**
     * Suspends reading because the client has used up its quota. Further data then fills the
     * socket's buffer, until the client can send no more.
     */
    private void throttle() throws CloseReason {
        long now = System.nanoTime();
        if (floodingSinceNanos == 0) {
            floodingSinceNanos = now;
        } else if (now - floodingSinceNanos > timeouts.flood().toNanos()) {
            throw CloseReason.cut(
                    "too-many-messages",
                    "for "
                            + timeouts.flood().toMillis() / 1000.0
                            + " s there were always more than "
                            + limits.messagesPerSecond()
                            + " messages in a second");
        }
        pause();
        connections.readLater(connection);
    }

    private void pause() {
        held = true;
        key.interestOpsAnd(~SelectionKey.OP_READ);
    }

    /** Continues to read if the client's quota allows it. */
    void resume() {
        release(null);
    }

    /**
     * Processes the first message of a client that had to wait before it could join. Does nothing
     * if the client has closed the connection.
     */
    void join() {
        if (wire.isOpen() && !connection.hasEnded()) {
            guard(
                    () -> {
                        if (!messages.fill(wire)) {
                            throw CloseReason.regular(
                                    "lost", "the client closed the connection before it joined");
                        }
                        mayJoin = true;
                        connections.countJoin();
                    });
        }
        release(null);
    }

    private void drain() throws IOException {
        if (!connection.hasWrittenAll()) {
            key.interestOpsAnd(~SelectionKey.OP_READ); // reading continues after all writes
            return;
        }
        int count = wire.read(connections.buffers().buffer());
        drained += count;
        if (count < 0 || drained > MAX_DRAINED_BYTES) {
            connection.close();
        }
    }

    private void take(ByteBuffer bytes) throws CloseReason {
        if (connection.session() == null && isHttp(bytes)) {
            throw CloseReason.cut(
                    "no-http",
                    "this is not a web server; a browser would let any page speak to it");
        }
        try {
            handle(MessageReader.read(bytes, connection.encoding()));
        } catch (BadMessage e) {
            refuse(e);
        }
    }

    /**
     * Returns whether a line is the first line of an HTTP request. A web page can make a browser
     * send arbitrary data to a local port, but an HTTP request line always comes first. The
     * connection is refused at this line.
     */
    private static boolean isHttp(ByteBuffer line) {
        return HTTP.matcher(StandardCharsets.ISO_8859_1.decode(line.duplicate())).find();
    }

    private void refuse(BadMessage message) throws CloseReason {
        counters.errors.increment();
        connection.send(message.error());
        errors++;
        if (errors >= limits.maxErrors()) {
            throw CloseReason.cut("too-many-errors", errors + " messages were refused");
        }
    }

    private void handle(ClientMessage message) throws BadMessage, CloseReason {
        Client agent = connection.session();
        if (agent == null) {
            connection.greet(message);
            messages.greeted(connection.encoding());
            return;
        }
        switch (message) {
            case ClientMessage.Hello again ->
                    throw new BadMessage(
                            again.id(),
                            "hello-again",
                            "this connection is " + agent + " already",
                            "open another connection for another agent");
            case ClientMessage.Perceive perceive -> agent.perceive(perceive);
            case ClientMessage.Look look when look.item().isPresent() ->
                    hold(() -> agent.look(look));
            case ClientMessage.Look look -> agent.look(look);
            case ClientMessage.Act act -> agent.request(act);
            case ClientMessage.Control control -> hold(() -> agent.request(control));
            case ClientMessage.Query query -> hold(() -> agent.request(query));
            case ClientMessage.Ready ready -> agent.ready(ready);
            case ClientMessage.Ping ping -> connection.send(new ServerMessage.Pong(ping.id()));
            case ClientMessage.Pong pong -> connection.ponged();
            case ClientMessage.Bye bye ->
                    throw CloseReason.regular("goodbye", "the agent said bye");
        }
    }

    private interface Command {
        void run() throws BadMessage;
    }

    /** Runs a long command on another thread. Meanwhile nothing is read from the client. */
    private void hold(Command command) {
        pause();
        connections
                .commands()
                .execute(
                        () -> {
                            try {
                                command.run();
                                connections.loop().later(() -> release(null));
                            } catch (BadMessage e) {
                                connections.loop().later(() -> release(e));
                            } catch (Throwable e) {
                                connection.fail(e);
                            }
                        });
    }

    private void release(@Nullable BadMessage refused) {
        held = false;
        if (!wire.isOpen()) {
            return;
        }
        key.interestOpsOr(SelectionKey.OP_READ);
        guard(
                () -> {
                    if (refused != null) {
                        refuse(refused);
                    }
                    takeAll();
                });
        if (!held && wire.isOpen()) {
            read(); // the TLS layer may have buffered data that the selection key does not report
        }
    }
}
