// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Relay;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.function.Supplier;

/**
 * One connection of a client. A connection belongs to a session after the client's hello. A
 * connection ends once, with a reason. The server then writes the waiting messages, and discards
 * further input until the client closes its side too. The server does not close the socket at once,
 * because unread input would then reset the connection. The client would not receive its {@code
 * bye}.
 */
public final class Connection implements EventLoop.Handler, Writers.Target {

    private final Connections connections;
    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Counters counters;
    private final Wire wire;
    private final @Nullable Relay relay;
    private final InetSocketAddress address;
    private final Outbox outbox;
    private final RoundTrip roundTrip;

    // For the event loop's thread only.
    private final ConnectionReader reader;
    private final ConnectionWriter writer;

    /** True while the connection is queued for writing, so that it is not queued twice. */
    private final AtomicBoolean queued = new AtomicBoolean();

    /** The session; null before the hello. Set once, under this object's lock. */
    private volatile @Nullable Client session;

    private volatile Encoding encoding = Encoding.JSON;
    private volatile @Nullable CloseReason ending;
    private volatile long endedNanos;

    /**
     * Creates the connection. Called on the event loop's thread.
     *
     * @param relay the server that passes messages on to the client; null if the client itself is
     *     connected
     * @throws IOException if the peer has closed the connection already
     */
    Connection(Connections connections, Wire wire, @Nullable Relay relay) throws IOException {
        this.relay = relay;
        this.connections = connections;
        this.limits = connections.limits();
        this.timeouts = connections.timeouts();
        this.counters = connections.counters();
        this.wire = wire;
        this.address = wire.peer();
        this.roundTrip = new RoundTrip(timeouts.idle().toNanos());
        this.outbox = new Outbox(limits.outboxMessages(), limits.outboxBytes(), this::wantToWrite);
        SelectionKey key = wire.register(connections.loop(), this, this::read);
        this.reader = new ConnectionReader(connections, this, wire, key);
        this.writer = new ConnectionWriter(connections, this, wire, key, outbox);
    }

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

    /** Returns whether another server of this process, such as the page, relays this connection. */
    public boolean isRelayed() {
        return relay != null;
    }

    /**
     * Notifies the server that relays this connection that the client was admitted. Does nothing if
     * no server relays the connection. Called before the welcome is queued.
     */
    public void welcomed(Role role, String world, String client) {
        if (relay != null) {
            relay.welcomed(role, world, client);
        }
    }

    /** Queues a message for the client. Ends the connection if too many messages are waiting. */
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

    /** Sends a ping to a silent client. */
    void ping() {
        roundTrip.begin(System.nanoTime());
        send(new ServerMessage.Ping());
    }

    /** Handles the client's answer to a ping. */
    void ponged() {
        roundTrip.end(System.nanoTime());
    }

    /**
     * Sends a ping to measure the round-trip time. Does nothing while the client still has to
     * answer a ping, or if it answered one a short time ago. For any thread.
     */
    public void measureRoundTrip() {
        if (!hasEnded() && roundTrip.begin(System.nanoTime())) {
            send(new ServerMessage.Ping());
        }
    }

    /**
     * Returns the time from the last answered ping to its answer [s]; empty before the first
     * answer. For any thread.
     */
    public OptionalDouble roundTripSeconds() {
        return roundTrip.seconds();
    }

    /**
     * Sends the message {@code bye} with a reason and ends the connection. Further calls have no
     * effect.
     */
    public synchronized void end(CloseReason why) {
        if (leave(why)) {
            // The session ends before `bye` is flushed. A client may therefore reconnect as soon as
            // it has read `bye`.
            outbox.finish(why.bye().in(encoding));
        }
    }

    /**
     * Ends the connection because a new one replaces it. Discards waiting messages, and writes
     * {@code bye} unless another message is partly written. For the event loop's thread only.
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
     * Records that the connection ends.
     *
     * @return false if the connection had ended before
     */
    private synchronized boolean leave(CloseReason why) {
        if (hasEnded()) {
            return false;
        }
        endedNanos = System.nanoTime();
        ending = why;
        Client client = session;
        if (client != null) {
            client.disconnected(outbox, why);
        }
        if (why.isCut()) {
            counters.cut.increment();
        }
        if (relay != null) {
            relay.ended();
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

    @Override
    public void ready(SelectionKey ready) {
        if (ready.isWritable()) {
            write(connections.buffers());
        }
        if (ready.isValid() && ready.isReadable()) {
            read();
        }
    }

    /** Ends the connection if the client exceeds a time limit. Called periodically. */
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
            } else {
                reader.checkTime(nowNanos);
            }
        } catch (CloseReason e) {
            end(e);
        }
    }

    /**
     * Ends the connection, because the data waiting for all slow clients exceeds its limit and this
     * client has been slow for the longest time.
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
        leave(
                CloseReason.regular(
                        "lost",
                        "the connection broke")); // the client cannot receive this reason any more
        try {
            wire.close();
        } catch (IOException e) {
            // The exception is ignored, because the operating system frees the file descriptor even
            // if close() fails.
        }
        connections.forget(this);
    }

    private void read() {
        reader.read();
    }

    /** Admits a client that had to wait before it could join. */
    void join() {
        reader.join();
    }

    /** Resumes reading if the client's quota allows it. */
    void readAgain() {
        reader.resume();
    }

    /**
     * Ends the connection after any error in the server, so that the agent does not stay in the
     * world. The error may also be an error of the Java virtual machine.
     */
    void fail(Throwable error) {
        connections.log().error("serving a connection failed", error);
        if (hasEnded()) {
            closeSoon();
        } else {
            end(CloseReason.regular("failed", "the server has an error; its log says more"));
        }
    }

    /** Returns the client; null before its hello. */
    @Nullable Client session() {
        return session;
    }

    /** Returns whether all messages are written and the output of the socket is shut down. */
    boolean hasWrittenAll() {
        return writer.isShut();
    }

    /** Handles the first message, which must be a hello. */
    synchronized void greet(ClientMessage message) throws BadMessage, CloseReason {
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
                            .filter(wanted -> relay == null || wanted == Encoding.JSON)
                            .orElseThrow(
                                    () ->
                                            CloseReason.refused(
                                                    "encoding-unsupported",
                                                    "this server does not write "
                                                            + Text.quote(hello.encoding())
                                                            + (relay == null ? "" : " to a page"),
                                                    "say hello with \"encoding\":\"json\""
                                                            + (relay == null
                                                                    ? " or \"encoding\":\"msgpack\""
                                                                    : "")));
            Optional<ServerMessage> answer = connections.door().answer(this, hello);
            if (answer.isPresent()) {
                answer(hello.name(), answer.get());
                throw CloseReason.regular("answered", "the server has answered your question");
            }
            session = connections.door().greet(this, hello);
            connections.known(this);
        }
    }

    /** Sends an answer to a client that has no session, and records it as belonging to no world. */
    private void answer(String name, ServerMessage answer) throws CloseReason {
        if (connections.audit().isPresent()
                && !connections
                        .audit()
                        .get()
                        .told("", name, encoding, ByteBuffer.wrap(answer.in(encoding)))) {
            throw CloseReason.notRecorded();
        }
        send(answer);
    }

    // ---- methods for the event loop's thread, or for another thread while the event loop waits
    // for it ----

    @Override
    public void writeQueued(WriteBuffers buffers) {
        queued.set(false);
        write(buffers);
    }

    /**
     * Writes waiting messages until the socket accepts no more. For the event loop's thread only.
     */
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
     * Replaces all waiting messages by {@code bye}. Omits {@code bye} if a message is partly
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
