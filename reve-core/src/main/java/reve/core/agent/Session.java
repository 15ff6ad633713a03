package reve.core.agent;

import java.io.BufferedOutputStream;
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.concurrent.atomic.AtomicInteger;
import org.jspecify.annotations.Nullable;

/**
 * One connection: a reader and a writer of its own, and what the agent behind it is waiting for. However it ends,
 * it ends once, with a reason.
 */
final class Session {

    private static final int SEND_BUFFER_BYTES = 64 * 1024;
    private static final int WRITE_BUFFER_BYTES = 16 * 1024;
    private static final int MAX_DRAINED_BYTES = 1024 * 1024;

    private final AgentServer server;
    private final AgentServerConfig config;
    private final Counters counters;
    private final Socket socket;
    private final Outbox outbox;
    private final PerceptionRequests perceptions;
    private final AtomicInteger actsInFlight = new AtomicInteger();
    private final Thread reader;
    private final Thread writer;
    private int errors;

    // Guarded by this.
    private ClientMessage.@Nullable Hello hello;
    private boolean welcomed;
    private long joinedInFrame;

    private volatile @Nullable Ending ending;
    private volatile long endedNanos;
    private volatile long writingSinceNanos;
    private volatile boolean writing;

    Session(AgentServer server, Socket socket) {
        this.server = server;
        this.config = server.config();
        this.counters = server.counters();
        this.socket = socket;
        this.outbox = new Outbox(config.outboxMessages(), config.outboxBytes());
        this.perceptions = new PerceptionRequests(outbox, counters.perceptions);
        this.reader = Thread.ofVirtual().name("agent reader").unstarted(this::read);
        this.writer = Thread.ofVirtual().name("agent writer").unstarted(this::write);
    }

    void start() {
        writer.start();
        reader.start();
    }

    PerceptionRequests perceptions() {
        return perceptions;
    }

    boolean hasEnded() {
        return ending != null;
    }

    // ---- publisher's thread ----

    /** The agent has its body, or cannot have one. */
    void joined(Outcome outcome) {
        switch (outcome) {
            case Outcome.Joined joined -> welcome(joined.body(), joined.frame());
            case Outcome.Refused no -> end(Ending.refused(no.code(), no.reason(), no.hint().orElse("")));
            case Outcome.Failed failed -> fail(failed.cause());
            case Outcome.Done done -> { }
            case Outcome.Absent absent -> { }
        }
    }

    private synchronized void welcome(String body, long frame) {
        ClientMessage.Hello greeting = hello;
        if (greeting == null || hasEnded()) {
            return;
        }
        welcomed = true;
        joinedInFrame = frame;
        counters.joined.increment();
        counters.agents.increment();
        perceptions.notBefore(frame);
        send(server.welcome(greeting, body, frame).line());
        server.admit(this);
        server.log().info("agent " + greeting.name() + " joined with body " + Text.quote(body));
    }

    synchronized long joinedInFrame() {
        return joinedInFrame;
    }

    /** An act of this agent has its outcome. */
    private void acted(ClientMessage.Act act, Outcome outcome) {
        switch (outcome) {
            case Outcome.Done done -> answer(new ServerMessage.Accepted(act.id(), done.frame()), done.frame());
            case Outcome.Refused no -> answer(new ServerMessage.Refused(act.id(), no.code(), no.reason()), no.frame());
            case Outcome.Failed failed -> {
                server.log().error("action " + Text.quote(act.action()) + " of item " + Text.quote(act.item())
                        + " failed", failed.cause());
                answer(new ServerMessage.Refused(act.id(), "action-failed", "the action " + Text.quote(act.action())
                        + " failed; the server's log says why"), failed.frame());
            }
            case Outcome.Joined joined -> { }
            case Outcome.Absent absent -> { }
        }
    }

    private void answer(ServerMessage result, long frame) {
        actsInFlight.decrementAndGet();
        (result instanceof ServerMessage.Accepted ? counters.actsAccepted : counters.actsRefused).increment();
        perceptions.notBefore(frame);
        send(result.line());
    }

    // ---- any thread ----

    /** Queues a line for the client; ends the connection if too much is waiting. */
    void send(byte[] line) {
        if (!outbox.offer(line)) {
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
        if (hello != null) {
            server.leave(hello.name(), why.code());
        }
        if (welcomed) {
            counters.agents.decrement();
        }
        if (why.isCut()) {
            counters.cut.increment();
        }
        report(why);
        outbox.finish(why.bye().line()); // who has read its bye has left, and may come back
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
        ClientMessage.Hello greeting = hello;
        String who = greeting == null ? "a client at " + socket.getRemoteSocketAddress() : "agent " + greeting.name();
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
            var lines = new LineReader(socket, config, () -> send(new ServerMessage.Ping().line()));
            for (ByteBuffer line = lines.next(); line != null && !hasEnded(); line = lines.next()) {
                counters.lines.increment();
                take(line, lines);
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

    private void take(ByteBuffer line, LineReader lines) throws Ending {
        try {
            handle(MessageReader.read(line), lines);
        } catch (BadMessage e) {
            counters.errors.increment();
            send(e.error().line());
            errors++;
            if (errors >= config.maxErrors()) {
                throw Ending.cut("too-many-errors", errors + " lines were refused");
            }
        }
    }

    private void handle(ClientMessage message, LineReader lines) throws BadMessage, Ending {
        ClientMessage.Hello said = hello;
        if (said == null && !(message instanceof ClientMessage.Hello)) {
            throw new BadMessage(message.id(), "hello-expected", "the first message must be hello",
                    "send {\"t\":\"hello\",\"protocol\":1,\"name\":\"ada\"}");
        }
        switch (message) {
            case ClientMessage.Hello greeting -> {
                if (said != null) {
                    throw new BadMessage(greeting.id(), "hello-again", "this connection is agent " + said.name()
                            + " already", "open another connection for another agent");
                }
                join(greeting);
                lines.greeted();
            }
            case ClientMessage.Perceive perceive -> perceptions.ask(perceive, server.published());
            case ClientMessage.Act act -> act(act, said);
            case ClientMessage.Ping ping -> send(new ServerMessage.Pong(ping.id()).line());
            case ClientMessage.Pong pong -> { }
            case ClientMessage.Bye bye -> throw Ending.regular("goodbye", "the agent said bye");
        }
    }

    private synchronized void join(ClientMessage.Hello greeting) throws Ending {
        if (!hasEnded()) {
            server.join(this, greeting);
            hello = greeting;
        }
    }

    private void act(ClientMessage.Act act, ClientMessage.Hello greeting) {
        var input = new AgentInput.Act(greeting.name(), act.item(), act.action(), act.arguments());
        if (actsInFlight.incrementAndGet() > config.actsInFlight()) {
            refuse(act, "too-many-acts", config.actsInFlight() + " acts wait for their result already");
        } else if (!server.act(input, outcome -> acted(act, outcome))) {
            refuse(act, "world-busy", "the world has more to do than fits into a frame");
        }
    }

    private void refuse(ClientMessage.Act act, String code, String reason) {
        answer(new ServerMessage.Refused(act.id(), code, reason), 0);
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

    private void write() {
        try {
            OutputStream out = new BufferedOutputStream(socket.getOutputStream(), WRITE_BUFFER_BYTES);
            for (Outbox.Line line = outbox.take(); line != null; line = outbox.take()) {
                writingSinceNanos = System.nanoTime();
                writing = true;
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
