// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.MessageReader;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.charset.StandardCharsets;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.function.Supplier;
import java.util.regex.Pattern;

import javax.net.ssl.SSLException;

/**
 * One connection, and its session after the hello. A connection ends once, with a reason. The
 * server then writes the waiting messages and discards further input until the client closes too.
 * If it closed at once, unread input would reset the connection, and the client would not receive
 * its {@code bye}.
 */
public final class Connection implements EventLoop.Handler, Writers.Target {

    private static final int MAX_DRAINED_BYTES = 1024 * 1024;
    private static final Pattern HTTP = Pattern.compile("^[A-Z]{3,10} .* HTTP/");

    private final Connections connections;
    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Counters counters;
    private final Wire wire;
    private final InetSocketAddress address;
    private final Outbox outbox;

    // The fields below belong to the event loop's thread.
    private final MessageFramer messages;
    private final SelectionKey key;
    private final ConnectionWriter writer;

    private int errors;

    /** True while reading is suspended. */
    private boolean held;

    /**
     * Time since which the client has sent more than its quota without a pause [ns]; 0 if it does
     * not.
     */
    private long floodingSinceNanos;

    private int drained;

    /** True while the connection is in the queue for writing, so that it is queued once. */
    private final AtomicBoolean queued = new AtomicBoolean();

    /** Set once, under this object's lock. */
    private volatile @Nullable Client session;

    private volatile Encoding encoding = Encoding.JSON;
    private volatile @Nullable CloseReason ending;
    private volatile long endedNanos;

    /**
     * Creates the connection. Called on the event loop's thread.
     *
     * @throws IOException if the peer has closed already
     */
    Connection(Connections connections, Wire wire) throws IOException {
        this.connections = connections;
        this.limits = connections.limits();
        this.timeouts = connections.timeouts();
        this.counters = connections.counters();
        this.wire = wire;
        this.address = wire.peer();
        this.outbox = new Outbox(limits.outboxMessages(), limits.outboxBytes(), this::wantToWrite);
        this.messages = new MessageFramer(limits, timeouts, () -> send(new ServerMessage.Ping()));
        this.key = wire.register(connections.loop(), this, this::read);
        this.writer = new ConnectionWriter(connections, this, wire, key, outbox);
    }

    // Methods for any thread.

    boolean hasEnded() {
        return ending != null;
    }

    /** Returns the queue of outgoing messages. */
    public Outbox outbox() {
        return outbox;
    }

    /** Returns the client's network address. */
    public InetAddress address() {
        return address.getAddress();
    }

    /** Returns the encoding of outgoing messages; JSON before the hello. */
    public Encoding encoding() {
        return encoding;
    }

    /** Queues a message for the client; ends the connection if too much is waiting. */
    public void send(ServerMessage message) {
        if (!outbox.offer(message.in(encoding))) {
            end(
                    CloseReason.cut(
                            "too-slow",
                            "more than "
                                    + limits.outboxMessages()
                                    + " messages or "
                                    + limits.outboxBytes()
                                    + " bytes wait to be read"));
        }
    }

    /** Sends {@code bye} and ends the connection. Only the first reason is sent. */
    public synchronized void end(CloseReason why) {
        if (leave(why)) {
            // The session ends before `bye` is flushed, so a client may reconnect as soon as it
            // reads it.
            outbox.finish(why.bye().in(encoding));
        }
    }

    /**
     * Ends because a new connection replaces this one. Discards waiting messages, and writes {@code
     * bye} unless a message is partly written. The event loop's thread.
     */
    public synchronized void replace(CloseReason why) {
        if (leave(why)) {
            outbox.abandon(why.bye().in(encoding));
            if (writer.isStuck()) {
                close();
            }
        }
    }

    /**
     * @return false if the connection has ended before
     */
    private synchronized boolean leave(CloseReason why) {
        if (hasEnded()) {
            return false;
        }
        endedNanos = System.nanoTime();
        ending = why;
        Client client = session;
        if (client != null) {
            client.disconnected(this, why);
        }
        if (why.isCut()) {
            counters.cut.increment();
        }
        report(why);
        return true;
    }

    private void report(CloseReason why) {
        Client client = session;
        RateLimitedLog log = client == null ? connections.strangersLog() : connections.log();
        Supplier<String> line =
                () ->
                        (client == null ? "a client at " + address : client)
                                + " left: "
                                + why.code()
                                + ": "
                                + why.getMessage();
        if (why.isCut()) {
            log.warn(line);
        } else {
            log.info(line);
        }
    }

    private void wantToWrite() {
        if (!queued.getAndSet(true)) {
            connections.writeSoon(this);
        }
    }

    // Methods for the event loop's thread.

    @Override
    public void ready(SelectionKey ready) {
        if (ready.isWritable()) {
            write(connections.buffers());
        }
        if (ready.isValid() && ready.isReadable()) {
            read();
        }
    }

    /** Checks time limits, and ends a connection that exceeds one. Called periodically. */
    void checkDeadlines(long nowNanos) {
        try {
            if (hasEnded()) {
                if (nowNanos - endedNanos > timeouts.linger().toNanos()) {
                    close();
                }
            } else if (writer.isStuckFor(timeouts.write().toNanos(), nowNanos)) {
                end(
                        CloseReason.cut(
                                "too-slow",
                                "a write took longer than "
                                        + timeouts.write().toMillis() / 1000.0
                                        + " s for 64 KiB"));
                close();
            } else if (!held) {
                messages.checkTime(nowNanos);
            }
        } catch (CloseReason e) {
            end(e);
        }
    }

    /**
     * Ends the connection because the server holds too much unread data, and this client has been
     * slow the longest.
     */
    void giveUp() {
        end(
                CloseReason.cut(
                        "too-slow",
                        "too much waits to be read by clients, and you have not read"
                                + " for the longest time"));
        close();
    }

    /** Closes the socket. */
    void close() {
        connections.slowReaders().release(this);
        leave(CloseReason.regular("lost", "the connection broke")); // the client is gone and cannot receive a reason
        try {
            wire.close();
        } catch (IOException e) {
            // Closing frees the descriptor even if it fails.
        }
        connections.forget(this);
    }

    private void read() {
        guard(
                () -> {
                    if (hasEnded()) {
                        drain();
                        return;
                    }
                    if (held) {
                        pause(); // the wire has data to write itself
                        return;
                    }
                    do {
                        boolean open = messages.fill(wire);
                        takeAll();
                        if (!open) {
                            throw CloseReason.regular(
                                    "lost", "the client closed the connection without a bye");
                        }
                    } while (wire.hasReceived() && !held && !hasEnded());
                });
    }

    private interface Reading {
        void read() throws IOException, CloseReason;
    }

    /** Runs a read; ends the connection with a reason if it fails. */
    private void guard(Reading reading) {
        try {
            reading.read();
        } catch (CloseReason e) {
            end(e);
        } catch (TlsWire.PlainTextException e) {
            end(CloseReason.refused("tls-expected", "this server speaks TLS", "connect with TLS"));
        } catch (SSLException e) {
            end(CloseReason.cut("tls-failed", "TLS failed: " + e.getMessage()));
            close();
        } catch (IOException e) {
            close();
        } catch (Throwable e) {
            fail(e);
        }
    }

    private void takeAll() throws CloseReason {
        while (!hasEnded() && !held) {
            Client client = session;
            if (client != null && !client.hasQuota()) {
                throttle();
                return;
            }
            ByteBuffer next = messages.next();
            if (next == null) {
                floodingSinceNanos = messages.hasTakenAll() ? 0 : floodingSinceNanos;
                return;
            }
            counters.lines.increment();
            if (client != null) {
                client.count();
            }
            take(next);
        }
    }

    /**
     * Suspends reading because the client has used up its quota. Further data waits in the socket,
     * then at the client.
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
        connections.readLater(this);
    }

    private void pause() {
        held = true;
        key.interestOpsAnd(~SelectionKey.OP_READ);
    }

    /** Resumes reading if the quota allows it. */
    void readAgain() {
        release(null);
    }

    private void drain() throws IOException {
        if (!writer.isShut()) {
            key.interestOpsAnd(~SelectionKey.OP_READ); // until all is written
            return;
        }
        int count = wire.read(connections.buffers().buffer());
        drained += count;
        if (count < 0 || drained > MAX_DRAINED_BYTES) {
            close();
        }
    }

    /**
     * Ends the connection after an error in the server, including errors of the virtual machine, so
     * that the agent does not stay in the world.
     */
    private void fail(Throwable error) {
        connections.log().error("serving a connection failed", error);
        if (hasEnded()) {
            closeSoon();
        } else {
            end(CloseReason.regular("failed", "the server has an error; its log says more"));
        }
    }

    private void take(ByteBuffer bytes) throws CloseReason {
        if (session == null && isHttp(bytes)) {
            throw CloseReason.cut(
                    "no-http",
                    "this is no web connections; a browser would let any page speak to it");
        }
        try {
            handle(MessageReader.read(bytes, encoding));
        } catch (BadMessage e) {
            refuse(e);
        }
    }

    /**
     * Recognizes an HTTP request line. A web page can send arbitrary data to a local port, but only
     * after such a line.
     */
    private static boolean isHttp(ByteBuffer line) {
        return HTTP.matcher(StandardCharsets.ISO_8859_1.decode(line.duplicate())).find();
    }

    private void refuse(BadMessage message) throws CloseReason {
        counters.errors.increment();
        send(message.error());
        errors++;
        if (errors >= limits.maxErrors()) {
            throw CloseReason.cut("too-many-errors", errors + " messages were refused");
        }
    }

    private void handle(ClientMessage message) throws BadMessage, CloseReason {
        Client agent = session;
        if (agent == null) {
            greet(message);
            messages.greeted(encoding);
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
            case ClientMessage.Look look -> agent.look(look);
            case ClientMessage.Act act -> agent.request(act);
            case ClientMessage.Control control -> hold(agent, control);
            case ClientMessage.Ready ready -> agent.ready(ready);
            case ClientMessage.Ping ping -> send(new ServerMessage.Pong(ping.id()));
            case ClientMessage.Pong pong -> {}
            case ClientMessage.Bye bye ->
                    throw CloseReason.regular("goodbye", "the agent said bye");
        }
    }

    /** Runs a long command on its own thread. Reading from the client is suspended meanwhile. */
    private void hold(Client client, ClientMessage.Control control) {
        pause();
        Thread.ofVirtual()
                .name("agent control")
                .start(
                        () -> {
                            try {
                                client.request(control);
                                connections.loop().later(() -> release(null));
                            } catch (BadMessage e) {
                                connections.loop().later(() -> release(e));
                            } catch (Throwable e) {
                                fail(e);
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
            read(); // the wire may hold data that the selection key does not report
        }
    }

    private synchronized void greet(ClientMessage message) throws BadMessage, CloseReason {
        if (!(message instanceof ClientMessage.Hello hello)) {
            throw new BadMessage(
                    message.id(),
                    "hello-expected",
                    "the first message must be hello",
                    "send {\"t\":\"hello\",\"protocol\":1,\"name\":\"ada\"}");
        }
        if (!hasEnded()) {
            encoding =
                    Encoding.of(hello.encoding())
                            .orElseThrow(
                                    () ->
                                            CloseReason.refused(
                                                    "encoding-unsupported",
                                                    "this server does not write "
                                                            + Text.quote(hello.encoding()),
                                                    "say hello with \"encoding\":\"json\" or"
                                                            + " \"encoding\":\"msgpack\""));
            session = connections.door().greet(this, hello);
            connections.known(this);
        }
    }

    // The methods below run on the event loop's thread, or on another thread while the event loop
    // waits for it.

    @Override
    public void writeQueued(WriteBuffers buffers) {
        queued.set(false);
        write(buffers);
    }

    /** Writes waiting messages until the socket accepts no more. The event loop's thread. */
    public void write() {
        write(connections.buffers());
    }

    private void write(WriteBuffers buffers) {
        try {
            writer.write(buffers, encoding, session);
        } catch (IOException e) {
            closeSoon();
        } catch (CloseReason e) {
            end(e);
            sayBye();
        } catch (Throwable e) {
            fail(e);
            sayBye();
        }
    }

    private void closeSoon() {
        connections.loop().later(this::close);
    }

    /**
     * Replaces all waiting messages by {@code bye}; sends not even that if a message is partly
     * written.
     */
    private void sayBye() {
        CloseReason why = ending;
        if (why == null || writer.isStuck() || !wire.isOpen()) {
            closeSoon();
            return;
        }
        try {
            writer.writeLast(why.bye().in(encoding));
        } catch (IOException e) {
            closeSoon();
        }
    }
}
