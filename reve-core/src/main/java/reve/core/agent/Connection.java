// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import org.jspecify.annotations.Nullable;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.charset.StandardCharsets;
import java.util.Objects;
import java.util.OptionalLong;
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
final class Connection implements EventLoop.Handler {

    private static final int MAX_DRAINED_BYTES = 1024 * 1024;
    private static final Pattern HTTP = Pattern.compile("^[A-Z]{3,10} .* HTTP/");
    private static final ByteBuffer NOTHING = ByteBuffer.allocate(0);

    /** What large perceptions cost besides the time to write them: memory, until they are read. */
    private static final long NANOS_PER_LARGE_BYTE = 4;

    /** So much of a write has to go in the time that one may take. */
    private static final int PROGRESS_BYTES = 64 * 1024;

    private final AgentServer server;
    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Counters counters;
    private final Wire wire;
    private final InetSocketAddress address;
    private final Outbox outbox;

    // The event loop's thread.
    private final FrameReader messages;
    private final SelectionKey key;
    private ByteBuffer unsent = NOTHING;

    /** Since when no more than {@link #PROGRESS_BYTES} of it have gone. */
    private long unsentSinceNanos;

    /** What of it had gone then. */
    private int progress;

    /** What is written holds a perception. */
    private boolean perceives;

    /** Its socket has room for much at a time. */
    private boolean expectsMuch;

    private long perceivedBytes;
    private int errors;

    /** Not read at the moment. */
    private boolean held;

    /** Since when it has always sent more than was taken; 0 if it has not. */
    private long floodingSinceNanos;

    private boolean shut;
    private int drained;

    /** It waits to be written to, once. */
    private final AtomicBoolean queued = new AtomicBoolean();

    /** Set once, with this held. */
    private volatile @Nullable Session session;

    private volatile Encoding encoding = Encoding.JSON;
    private volatile @Nullable Ending ending;
    private volatile long endedNanos;

    /** On the event loop. @throws IOException if it is gone already */
    Connection(AgentServer server, Wire wire) throws IOException {
        this.server = server;
        this.limits = server.config().limits();
        this.timeouts = server.config().timeouts();
        this.counters = server.counters();
        this.wire = wire;
        this.address = wire.peer();
        this.outbox = new Outbox(limits.outboxMessages(), limits.outboxBytes(), this::wantToWrite);
        this.messages = new FrameReader(server.config(), () -> send(new ServerMessage.Ping()));
        this.key = wire.register(server.loop(), this, this::read);
    }

    // ---- any thread ----

    boolean hasEnded() {
        return ending != null;
    }

    Outbox outbox() {
        return outbox;
    }

    /** Where the client is. */
    InetAddress address() {
        return address.getAddress();
    }

    /** How it is written to; JSON until the hello has come. */
    Encoding encoding() {
        return encoding;
    }

    /** Queues a message for the client; ends the connection if too much is waiting. */
    void send(ServerMessage message) {
        if (!outbox.offer(message.in(encoding))) {
            end(
                    Ending.cut(
                            "too-slow",
                            "more than "
                                    + limits.outboxMessages()
                                    + " messages or "
                                    + limits.outboxBytes()
                                    + " bytes wait to be read"));
        }
    }

    /** Says bye and lets go; the first reason counts. */
    synchronized void end(Ending why) {
        if (leave(why)) {
            // Who has read its bye has left, and may come back.
            outbox.finish(why.bye().in(encoding));
        }
    }

    /**
     * Ends as another connection has taken its place: what waits is discarded, and the bye is
     * written if it would not be in the middle of a message. The event loop's thread.
     */
    synchronized void replace(Ending why) {
        if (leave(why)) {
            outbox.abandon(why.bye().in(encoding));
            if (isStuck()) {
                close();
            }
        }
    }

    /**
     * @return false if it has ended before
     */
    private synchronized boolean leave(Ending why) {
        if (hasEnded()) {
            return false;
        }
        endedNanos = System.nanoTime();
        ending = why;
        Session client = session;
        if (client != null) {
            client.disconnected(this, why);
        }
        if (why.isCut()) {
            counters.cut.increment();
        }
        report(why);
        return true;
    }

    private void report(Ending why) {
        Session client = session;
        RateLimitedLog log = client == null ? server.strangersLog() : server.log();
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
            server.writeSoon(this);
        }
    }

    // ---- the event loop's thread ----

    @Override
    public void ready(SelectionKey ready) {
        if (ready.isWritable()) {
            write(server.pen());
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
            } else if (isStuck() && nowNanos - unsentSinceNanos > timeouts.write().toNanos()) {
                end(
                        Ending.cut(
                                "too-slow",
                                "a write took longer than "
                                        + timeouts.write().toMillis() / 1000.0
                                        + " s for 64 KiB"));
                close();
            } else if (!held) {
                messages.checkTime(nowNanos);
            }
        } catch (Ending e) {
            end(e);
        }
    }

    /** More waits to be read than the server keeps, and this client has waited the longest. */
    void giveUp() {
        end(
                Ending.cut(
                        "too-slow",
                        "too much waits to be read by clients, and you have not read"
                                + " for the longest time"));
        close();
    }

    /** Lets go of the socket. */
    void close() {
        server.slowReaders().release(this);
        leave(Ending.regular("lost", "the connection broke")); // nobody is there to be told
        try {
            wire.close();
        } catch (IOException e) {
            // Closing frees the descriptor even when it complains.
        }
        server.forget(this);
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
                            throw Ending.regular(
                                    "lost", "the client closed the connection without a bye");
                        }
                    } while (wire.hasReceived() && !held && !hasEnded());
                });
    }

    private interface Reading {
        void read() throws IOException, Ending;
    }

    /** However it fails, the connection ends with a reason. */
    private void guard(Reading reading) {
        try {
            reading.read();
        } catch (Ending e) {
            end(e);
        } catch (TlsWire.PlainTextException e) {
            end(Ending.refused("tls-expected", "this server speaks TLS", "connect with TLS"));
        } catch (SSLException e) {
            end(Ending.cut("tls-failed", "TLS failed: " + e.getMessage()));
            close();
        } catch (IOException e) {
            close();
        } catch (Throwable e) {
            fail(e);
        }
    }

    private void takeAll() throws Ending {
        while (!hasEnded() && !held) {
            Session client = session;
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
    private void throttle() throws Ending {
        long now = System.nanoTime();
        if (floodingSinceNanos == 0) {
            floodingSinceNanos = now;
        } else if (now - floodingSinceNanos > timeouts.flood().toNanos()) {
            throw Ending.cut(
                    "too-many-messages",
                    "for "
                            + timeouts.flood().toMillis() / 1000.0
                            + " s there were always more than "
                            + limits.messagesPerSecond()
                            + " messages in a second");
        }
        pause();
        server.readLater(this);
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
        if (!shut) {
            key.interestOpsAnd(~SelectionKey.OP_READ); // until all is written
            return;
        }
        int count = wire.read(server.pen().buffer());
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
        server.log().error("serving a connection failed", error);
        if (hasEnded()) {
            closeSoon();
        } else {
            end(Ending.regular("failed", "the server has an error; its log says more"));
        }
    }

    private void take(ByteBuffer bytes) throws Ending {
        if (session == null && isHttp(bytes)) {
            throw Ending.cut(
                    "no-http", "this is no web server; a browser would let any page speak to it");
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

    private void refuse(BadMessage message) throws Ending {
        counters.errors.increment();
        send(message.error());
        errors++;
        if (errors >= limits.maxErrors()) {
            throw Ending.cut("too-many-errors", errors + " messages were refused");
        }
    }

    private void handle(ClientMessage message) throws BadMessage, Ending {
        Session agent = session;
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
            case ClientMessage.Bye bye -> throw Ending.regular("goodbye", "the agent said bye");
        }
    }

    /** What may take its time is done on a thread of its own; meanwhile the client is not read. */
    private void hold(Session client, ClientMessage.Control control) {
        pause();
        Thread.ofVirtual()
                .name("agent control")
                .start(
                        () -> {
                            try {
                                client.request(control);
                                server.loop().later(() -> release(null));
                            } catch (BadMessage e) {
                                server.loop().later(() -> release(e));
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

    private synchronized void greet(ClientMessage message) throws BadMessage, Ending {
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
                                            Ending.refused(
                                                    "encoding-unsupported",
                                                    "this server does not write "
                                                            + Text.quote(hello.encoding()),
                                                    "say hello with \"encoding\":\"json\" or"
                                                            + " \"encoding\":\"msgpack\""));
            session = server.greet(this, hello);
            server.known(this);
        }
    }

    // ---- writing: the event loop's thread, or another while that waits for it ----

    /** Writes what it was queued for with {@link AgentServer#writeSoon}. */
    void writeQueued(Pen pen) {
        queued.set(false);
        write(pen);
    }

    /** Writes what waits, as far as the socket takes it. */
    void write(Pen pen) {
        try {
            if (wire.isOpen() && !shut) {
                if (!writeAll(pen)) {
                    server.slowReaders().count(this, unsent.remaining() + outbox.bytes());
                } else if (outbox.isDone()) {
                    shut();
                }
            }
        } catch (IOException e) {
            closeSoon();
        } catch (Ending e) {
            end(e);
            sayBye();
        } catch (Throwable e) {
            fail(e);
            sayBye();
        }
    }

    private void closeSoon() {
        server.loop().later(this::close);
    }

    /** Says nothing any more of what waits, but why; not even that in the middle of a message. */
    private void sayBye() {
        Ending why = ending;
        if (why == null || isStuck() || !wire.isOpen()) {
            closeSoon();
            return;
        }
        try {
            wire.write(ByteBuffer.wrap(why.bye().in(encoding)));
            shut();
        } catch (IOException e) {
            closeSoon();
        }
    }

    private boolean writeAll(Pen pen) throws IOException, Ending {
        long begin = System.nanoTime();
        perceives = false;
        perceivedBytes = 0;
        try {
            return writeWaiting(pen);
        } finally {
            Session client = session;
            if (perceives && client != null) {
                client.perceptionCost()
                        .wrote(
                                System.nanoTime()
                                        - begin
                                        + NANOS_PER_LARGE_BYTE
                                                * Math.max(0, perceivedBytes - Pen.BUFFER_BYTES));
            }
        }
    }

    /**
     * @return true if nothing is left to be written
     */
    private boolean writeWaiting(Pen pen) throws IOException, Ending {
        while (writeUnsent()) {
            Bytes out = pen.bytes();
            Outbox.Waiting next = outbox.poll();
            while (next != null) {
                append(next, out, pen.difference());
                next = out.size() < Pen.BUFFER_BYTES ? outbox.poll() : null;
            }
            if (out.size() == 0) {
                return true;
            }
            send(out, pen.buffer());
        }
        return false;
    }

    private void append(Outbox.Waiting next, Bytes out, Difference difference) throws Ending {
        int start = out.size();
        Session client = session;
        switch (next) {
            case Outbox.Message message -> out.put(message.bytes());
            case Outbox.Missed missed ->
                    out.put(
                            ServerMessage.Event.missed(
                                            OptionalLong.of(missed.events()),
                                            missed.first(),
                                            missed.last())
                                    .in(encoding));
            case Outbox.Perception seen -> {
                perceives = true;
                int from = out.size();
                Objects.requireNonNull(client)
                        .world()
                        .publisher()
                        .telling()
                        .write(out, difference, encoding, seen);
                perceivedBytes += out.size() - from;
            }
        }
        if (client != null
                && server.audit().isPresent()
                && !server.audit()
                        .get()
                        .told(client.world().name(), client.name(), encoding, out.view(start))) {
            throw AgentServer.notRecorded();
        }
    }

    private void send(Bytes out, ByteBuffer piece) throws IOException {
        for (int sent = 0; sent < out.size() && !isStuck(); ) {
            out.get(sent, piece.clear());
            wire.write(piece.flip());
            sent += piece.position();
            if (piece.hasRemaining() || wire.hasUnsent()) {
                unsent = sent < out.size() ? ByteBuffer.wrap(out.copy(sent)) : NOTHING;
                unsentSinceNanos = System.nanoTime();
                progress = 0;
                if (!expectsMuch && unsent.remaining() > Pen.BUFFER_BYTES) {
                    expectsMuch = true;
                    wire.expectMuch();
                }
                server.slowReaders().hold(this, unsent.remaining());
            }
        }
    }

    /**
     * @return true if nothing is left of what was to be written
     */
    private boolean writeUnsent() throws IOException {
        if (isStuck()) {
            writePieces();
            if (unsent.position() - progress >= PROGRESS_BYTES) {
                progress = unsent.position();
                unsentSinceNanos = System.nanoTime();
            }
            if (isStuck()) {
                key.interestOpsOr(SelectionKey.OP_WRITE);
                return false;
            }
            unsent = NOTHING;
            server.slowReaders().release(this);
            key.interestOpsAnd(~SelectionKey.OP_WRITE);
        }
        return true;
    }

    /** The system copies all that it is offered, however little of it a socket takes. */
    private void writePieces() throws IOException {
        int end = unsent.limit();
        do {
            unsent.limit(Math.min(end, unsent.position() + Pen.BUFFER_BYTES));
            wire.write(unsent);
        } while (!unsent.hasRemaining() && unsent.limit() < end && !wire.hasUnsent());
        unsent.limit(end);
    }

    private boolean isStuck() {
        return unsent.hasRemaining() || wire.hasUnsent();
    }

    /** All is written; the client closes next. */
    private void shut() throws IOException {
        if (!shut) {
            shut = true;
            wire.shutdownOutput();
            key.interestOpsOr(SelectionKey.OP_READ);
        }
    }
}
