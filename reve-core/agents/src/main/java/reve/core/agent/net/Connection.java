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
 * One connection, and the session behind it once it has said hello. However it ends, it ends once,
 * with a reason: then what waits is written, and what the client still sends is read and thrown
 * away until it closes too, since its last lines would else reset the connection before it has read
 * its bye.
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

    // The event loop's thread.
    private final MessageFramer messages;
    private final SelectionKey key;
    private final ConnectionWriter writer;

    private int errors;

    /** Not read at the moment. */
    private boolean held;

    /** Since when it has always sent more than was taken; 0 if it has not. */
    private long floodingSinceNanos;

    private int drained;

    /** It waits to be written to, once. */
    private final AtomicBoolean queued = new AtomicBoolean();

    /** Set once, with this held. */
    private volatile @Nullable Client session;

    private volatile Encoding encoding = Encoding.JSON;
    private volatile @Nullable CloseReason ending;
    private volatile long endedNanos;

    /** On the event loop. @throws IOException if it is gone already */
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

    // ---- any thread ----

    boolean hasEnded() {
        return ending != null;
    }

    /** Returns what waits to be written. */
    public Outbox outbox() {
        return outbox;
    }

    /** Where the client is. */
    public InetAddress address() {
        return address.getAddress();
    }

    /** How it is written to; JSON until the hello has come. */
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

    /** Says bye and lets go; the first reason counts. */
    public synchronized void end(CloseReason why) {
        if (leave(why)) {
            // Who has read its bye has left, and may come back.
            outbox.finish(why.bye().in(encoding));
        }
    }

    /**
     * Ends as another connection has taken its place: what waits is discarded, and the bye is
     * written if it would not be in the middle of a message. The event loop's thread.
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
     * @return false if it has ended before
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

    // ---- the event loop's thread ----

    @Override
    public void ready(SelectionKey ready) {
        if (ready.isWritable()) {
            write(connections.buffers());
        }
        if (ready.isValid() && ready.isReadable()) {
            read();
        }
    }

    /** Called every now and then; ends what takes too long. */
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

    /** More waits to be read than the server keeps, and this client has waited the longest. */
    void giveUp() {
        end(
                CloseReason.cut(
                        "too-slow",
                        "too much waits to be read by clients, and you have not read"
                                + " for the longest time"));
        close();
    }

    /** Lets go of the socket. */
    void close() {
        connections.slowReaders().release(this);
        leave(CloseReason.regular("lost", "the connection broke")); // nobody is there to be told
        try {
            wire.close();
        } catch (IOException e) {
            // Closing frees the descriptor even when it complains.
        }
        connections.forget(this);
    }

    // ---- reading ----

    private void read() {
        guard(
                () -> {
                    if (hasEnded()) {
                        drain();
                        return;
                    }
                    if (held) {
                        pause(); // its wire had something to say of its own
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

    /** However it fails, the connection ends with a reason. */
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

    /** It has sent more than it may: the rest waits in its socket, and then with the client. */
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

    /** Reads it again, if it may send something. */
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
     * An error in the server, even of the virtual machine: the agent must not stay behind in the
     * world.
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
     * A page in a browser can send what it likes to this machine, but only behind a line like this.
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

    /** What may take its time is done on a thread of its own; meanwhile the client is not read. */
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
            read(); // the wire may hold what the key says nothing of
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

    // ---- writing: the event loop's thread, or another while that waits for it ----

    @Override
    public void writeQueued(WriteBuffers buffers) {
        queued.set(false);
        write(buffers);
    }

    /** Writes what waits, as far as the socket takes it. The event loop's thread. */
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

    /** Says nothing any more of what waits, but why; not even that in the middle of a message. */
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
