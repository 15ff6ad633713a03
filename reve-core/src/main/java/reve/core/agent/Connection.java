package reve.core.agent;

import java.io.BufferedOutputStream;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.time.Duration;
import org.jspecify.annotations.Nullable;

/**
 * One connection: a reader and a writer of its own, and the session behind it once it has said hello. However it
 * ends, it ends once, with a reason.
 */
final class Connection {

    private static final int SEND_BUFFER_BYTES = 64 * 1024;
    private static final int WRITE_BUFFER_BYTES = 16 * 1024;
    private static final int MAX_DRAINED_BYTES = 1024 * 1024;

    private final AgentServer server;
    private final AgentServerConfig config;
    private final Counters counters;
    private final Socket socket;
    private final Outbox outbox;
    private final Thread reader;
    private final Thread writer;
    private int errors;

    /** Set once, with this held. */
    private volatile @Nullable Session session;

    private volatile Encoding encoding = Encoding.JSON;
    private volatile @Nullable Ending ending;
    private volatile long endedNanos;
    private volatile long writingSinceNanos;
    private volatile boolean writing;

    Connection(AgentServer server, Socket socket) {
        this.server = server;
        this.config = server.config();
        this.counters = server.counters();
        this.socket = socket;
        this.outbox = new Outbox(config.outboxMessages(), config.outboxBytes());
        this.reader = Thread.ofVirtual().name("agent reader").unstarted(this::read);
        this.writer = Thread.ofVirtual().name("agent writer").unstarted(this::write);
    }

    void start() {
        writer.start();
        reader.start();
    }

    // ---- any thread ----

    boolean hasEnded() {
        return ending != null;
    }

    Outbox outbox() {
        return outbox;
    }

    /** How it is written to; JSON until the hello has come. */
    Encoding encoding() {
        return encoding;
    }

    /** Queues a message for the client; ends the connection if too much is waiting. */
    void send(ServerMessage message) {
        if (!outbox.offer(message.in(encoding))) {
            end(Ending.cut("too-slow", "more than " + config.outboxMessages() + " messages or "
                    + config.outboxBytes() + " bytes wait to be read"));
        }
    }

    /** Says bye and lets go; the first reason counts. */
    synchronized void end(Ending why) {
        if (hasEnded()) {
            return;
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
        outbox.finish(why.bye().in(encoding)); // who has read its bye has left, and may come back
    }

    /** Called every now and then; ends a write that takes too long and a connection that does not go. */
    void checkDeadlines(long nowNanos) {
        if (writing && nowNanos - writingSinceNanos > config.write().toNanos()) {
            end(Ending.cut("too-slow", "a write took longer than " + config.write().toMillis() / 1000.0 + " s"));
            closeSocket();
        } else if (hasEnded() && nowNanos - endedNanos > config.linger().toNanos()) {
            closeSocket();
        }
    }

    /** Waits until the connection is gone. @return false if it is still there after that time */
    boolean join(Duration timeout) throws InterruptedException {
        return reader.join(timeout);
    }

    void closeSocket() {
        try {
            socket.close();
        } catch (IOException e) {
            // Closing frees the descriptor even when it complains.
        }
    }

    private void report(Ending why) {
        String who = session == null ? "a client at " + socket.getRemoteSocketAddress() : session.toString();
        String line = who + " left: " + why.code() + ": " + why.getMessage();
        if (why.isCut()) {
            server.log().warn(line);
        } else {
            server.log().info(line);
        }
    }

    // ---- reader ----

    private void read() {
        try {
            socket.setTcpNoDelay(true);
            socket.setSendBufferSize(SEND_BUFFER_BYTES);
            var messages = new FrameReader(socket, config, () -> send(new ServerMessage.Ping()));
            for (ByteBuffer next = messages.next(); next != null && !hasEnded(); next = messages.next()) {
                counters.lines.increment();
                take(next, messages);
            }
            end(Ending.regular("lost", "the client closed the connection without a bye"));
        } catch (Ending e) {
            end(e);
        } catch (IOException e) {
            end(Ending.regular("lost", "the connection broke"));
        } catch (Throwable e) {
            fail(e);
        } finally {
            letGo();
            server.forget(this);
        }
    }

    /** An error in the server, even of the virtual machine: the agent must not stay behind in the world. */
    private void fail(Throwable error) {
        server.log().error("serving a connection failed", error);
        end(Ending.regular("failed", "the server has an error; its log says more"));
    }

    private void take(ByteBuffer bytes, FrameReader messages) throws Ending {
        try {
            handle(MessageReader.read(bytes, encoding), messages);
        } catch (BadMessage e) {
            counters.errors.increment();
            send(e.error());
            errors++;
            if (errors >= config.maxErrors()) {
                throw Ending.cut("too-many-errors", errors + " messages were refused");
            }
        }
    }

    private void handle(ClientMessage message, FrameReader messages) throws BadMessage, Ending {
        Session agent = session;
        if (agent == null) {
            greet(message);
            messages.greeted(encoding);
            return;
        }
        switch (message) {
            case ClientMessage.Hello again -> throw new BadMessage(again.id(), "hello-again",
                    "this connection is " + agent + " already", "open another connection for another agent");
            case ClientMessage.Perceive perceive -> agent.perceive(perceive);
            case ClientMessage.Request request -> agent.request(request);
            case ClientMessage.Ping ping -> send(new ServerMessage.Pong(ping.id()));
            case ClientMessage.Pong pong -> { }
            case ClientMessage.Bye bye -> throw Ending.regular("goodbye", "the agent said bye");
        }
    }

    private synchronized void greet(ClientMessage message) throws BadMessage, Ending {
        if (!(message instanceof ClientMessage.Hello hello)) {
            throw new BadMessage(message.id(), "hello-expected", "the first message must be hello",
                    "send {\"t\":\"hello\",\"protocol\":1,\"name\":\"ada\"}");
        }
        if (!hasEnded()) {
            encoding = Encoding.of(hello.encoding()).orElseThrow(() -> Ending.refused("encoding-unsupported",
                    "this server does not write " + Text.quote(hello.encoding()),
                    "say hello with \"encoding\":\"json\" or \"encoding\":\"msgpack\""));
            session = server.greet(this, hello);
        }
    }

    /** Closes so that the last line arrives: what the client still sends would else reset the connection. */
    private void letGo() {
        try (socket) {
            writer.join();
            InputStream in = socket.getInputStream();
            socket.setSoTimeout(Math.toIntExact(config.linger().toMillis()));
            byte[] ignored = new byte[1024];
            int drained = 0;
            for (int count = 0; count >= 0 && drained < MAX_DRAINED_BYTES; count = in.read(ignored)) {
                drained += count;
            }
        } catch (IOException e) {
            // The client, or our deadline, was faster.
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        }
    }

    // ---- writer ----

    private void record(Outbox.Line line) {
        Session client = session;
        if (client != null) {
            server.audit().ifPresent(audit -> audit.told(client.name(), encoding, line));
        }
    }

    private void write() {
        try {
            OutputStream out = new BufferedOutputStream(socket.getOutputStream(), WRITE_BUFFER_BYTES);
            for (Outbox.Line line = outbox.take(); line != null; line = outbox.take()) {
                writingSinceNanos = System.nanoTime();
                writing = true;
                record(line);
                out.write(line.head());
                out.write(line.tail());
                if (outbox.isEmpty()) {
                    out.flush();
                }
                writing = false;
            }
            out.flush();
            socket.shutdownOutput();
        } catch (IOException e) {
            end(Ending.regular("lost", "the connection broke"));
            closeSocket();
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        } catch (Throwable e) {
            fail(e);
            closeSocket();
        } finally {
            writing = false;
        }
    }
}
