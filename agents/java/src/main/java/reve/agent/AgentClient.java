// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import org.jspecify.annotations.Nullable;

import tools.jackson.databind.node.ObjectNode;

import java.io.EOFException;
import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.SocketException;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.function.BooleanSupplier;
import java.util.function.LongFunction;
import java.util.function.Supplier;

/**
 * An agent in a world. Calls block until the server has answered. A thread of the client reads
 * messages and answers the server's pings while the agent computes. Methods may be called from any
 * thread.
 *
 * <p>With {@link Join#withGrace} the client reconnects automatically when its connection breaks.
 * Calls in progress still receive their answers, and the server executes no action twice. If the
 * world moves to another server of a cluster, the client continues there.
 *
 * <p>Every call throws {@link DisconnectedException} after the connection has ended, and {@link
 * AgentException} with code {@code no-answer} if the server does not answer within {@link
 * Join#patience}.
 */
public final class AgentClient implements AutoCloseable {

    /** Maximum number of events that wait for {@link #events()}; the oldest are discarded. */
    public static final int MAX_EVENTS = 1024;

    private static final Duration RETRY = Duration.ofMillis(200);

    /** Maximum wait for an answer to a resume, if the client knows several servers. */
    private static final Duration ATTEMPT = Duration.ofSeconds(5);

    /** Code of the reason if another server of a cluster has the world. */
    private static final String MOVED = "moved";

    /** Code of a refusal while no server of a cluster has the world. */
    private static final String STARTING = "world-starting";

    /** Code of the end of a server. */
    private static final String CLOSING = "closing";

    /**
     * Maximum number of times that servers of a cluster may refer a client to another server
     * without a pause.
     */
    private static final int MOST_MOVES = 4;

    /** Maximum number of such pauses, in which the servers learn where the world is. */
    private static final int MOST_ROUNDS = 10;

    /** Code of the failure of a server that accepts connections and does not answer. */
    private static final String NO_ANSWER = "no-answer";

    /** Code of a temporary refusal to resume the session; the client tries again. */
    private static final String TOO_OFTEN = "resumed-too-often";

    /** The server that has the world. Only the reader's thread changes it. */
    private volatile InetSocketAddress address;

    /**
     * The servers of the cluster that the client knows. Only the reader's thread uses this list.
     */
    private final List<InetSocketAddress> known = new ArrayList<>();

    private final Duration patience;
    private final Welcome welcome;
    private final Thread reader;

    /**
     * Lock for sending. A thread that needs both locks acquires this one before this object's own
     * lock.
     */
    private final Object sending = new Object();

    /**
     * The current connection. The reader's thread replaces it after a reconnection, while this
     * thread holds {@link #sending}.
     */
    private volatile Wire wire;

    // The state of the session. Guarded by this object's lock.
    private final Conversation talk;
    private @Nullable AgentException end;

    /**
     * Joins the world at an address, with a body that the world chooses. Joins another server of a
     * cluster if that server has the world. Tries again while the cluster starts the world.
     *
     * @throws IOException if no server listens there
     * @throws DisconnectedException with the server's code if the agent may not join
     */
    public static AgentClient connect(String host, int port, String name) throws IOException {
        return connect(host, port, Join.as(name));
    }

    /** Joins with the given settings. */
    public static AgentClient connect(String host, int port, Join join) throws IOException {
        return new AgentClient(InetSocketAddress.createUnresolved(host, port), join);
    }

    /**
     * Asks a server for the nodes and worlds of its cluster, without joining a world. A world that
     * sleeps continues to sleep.
     *
     * @param join name, token, TLS and patience; the role must be control
     * @return the answer; its value is that of the command {@code cluster}
     * @throws IOException if no server listens there
     * @throws DisconnectedException with the server's code if it refuses the question
     */
    public static ActResult cluster(String host, int port, Join join) throws IOException {
        long end = System.nanoTime() + join.patience().toNanos();
        while (true) {
            try {
                return Wire.ask(InetSocketAddress.createUnresolved(host, port), join, "cluster");
            } catch (DisconnectedException refused) {
                if (!refused.code().equals(STARTING) || System.nanoTime() - end > 0) {
                    throw refused;
                }
            } catch (EOFException e) {
                throw lost(e);
            }
            LockSupport.parkNanos(RETRY.toNanos());
        }
    }

    private AgentClient(InetSocketAddress address, Join join) throws IOException {
        this.patience = join.patience();
        Found found = find(address, join);
        this.address = found.address();
        known.add(found.address());
        if (!known.contains(address)) {
            known.add(address);
        }
        wire = found.opened().wire();
        welcome = found.opened().welcome();
        knowServers(welcome);
        talk = new Conversation(join, welcome);
        reader = Thread.ofVirtual().name("reve agent " + join.name()).start(this::read);
    }

    /** The server that has the world, and the connection to it. */
    private record Found(InetSocketAddress address, Wire.Opened opened) {}

    /**
     * Connects to the server that has the world. A server of a cluster may refer the client to
     * another server. Tries again while the cluster starts the world, until the patience is over.
     */
    private static Found find(InetSocketAddress first, Join join) throws IOException {
        long end = System.nanoTime() + join.patience().toNanos();
        InetSocketAddress at = first;
        int moves = 0;
        int rounds = 0;
        while (true) {
            try {
                return new Found(at, open(at, join));
            } catch (DisconnectedException refused) {
                if (refused.address().isPresent() && moves < MOST_MOVES) {
                    moves++;
                    at = refused.address().get();
                    continue;
                }
                // Another server may have sent the client to this one, which has ended since.
                boolean hasEnded = refused.code().equals(CLOSING) && moves > 0;
                boolean isAstray = refused.address().isPresent() && rounds++ < MOST_ROUNDS;
                boolean isTemporary = refused.code().equals(STARTING) || hasEnded || isAstray;
                if (!isTemporary || System.nanoTime() - end > 0) {
                    throw refused;
                }
            } catch (IOException lost) {
                // The cluster may just have lost this server, so the client tries the first server
                // again.
                if (moves == 0 || System.nanoTime() - end > 0) {
                    throw lost;
                }
            }
            at = first;
            moves = 0;
            LockSupport.parkNanos(RETRY.toNanos());
        }
    }

    private static Wire.Opened open(InetSocketAddress address, Join join) throws IOException {
        try {
            return Wire.open(address, join);
        } catch (EOFException e) {
            throw lost(e);
        }
    }

    /** Returns the welcome: the agent's body, the world, the limits. */
    public Welcome welcome() {
        return welcome;
    }

    /** Returns the items of the next frame. */
    public Perception perceive() {
        return ask(Protocol::perceive, Perception.class);
    }

    /**
     * Returns the items of the next frame, with relations. The symbols (named facts) of items with
     * a shape then also contain the relations {@code near}, {@code on}, {@code inside} and {@code
     * touching}. Each relation lists the names of other items.
     */
    public Perception perceiveWithRelations() {
        return ask(Protocol::perceiveWithRelations, Perception.class);
    }

    /**
     * Requests a perception every {@code frames} frames from now on. {@link #nextPerception()}
     * returns these perceptions.
     *
     * @throws IllegalStateException in lock-step, where each round has a perception
     */
    public void perceiveEvery(int frames) {
        if (welcome.lockStep().isPresent()) {
            throw new IllegalStateException(
                    "an agent in lock-step perceives its rounds: use observe or step");
        }
        if (frames < 1) {
            throw new IllegalArgumentException("every " + frames + " frames, expected 1 or more");
        }
        say(() -> talk.subscribe(frames));
    }

    /**
     * Waits for the newest perception that this method has not returned yet. Older perceptions are
     * skipped if the agent is slow.
     *
     * @throws IllegalStateException without {@link #perceiveEvery}
     */
    public synchronized Perception nextPerception() {
        if (!talk.isSubscribed()) {
            throw new IllegalStateException("call perceiveEvery before nextPerception");
        }
        await(talk::hasNews, patience.plus(talk.pace()));
        return talk.news();
    }

    /** Ends the perceptions of {@link #perceiveEvery}. */
    public void stopPerceiving() {
        synchronized (sending) {
            Optional<byte[]> farewell;
            synchronized (this) {
                farewell = talk.unsubscribe();
            }
            farewell.ifPresent(this::send);
        }
    }

    /**
     * Returns a picture from one of the body's cameras.
     *
     * @throws AgentException with the server's code if there is no picture
     */
    public Image look(String sensor) {
        return ask(id -> Protocol.look(id, sensor), Image.class);
    }

    /**
     * Returns a picture from a camera of any body. For the role control.
     *
     * @param item name of the body
     * @throws AgentException with the server's code if there is no picture
     */
    public Image look(String sensor, String item) {
        return ask(id -> Protocol.look(id, sensor).put("item", item), Image.class);
    }

    /**
     * Performs an action of an item and waits for the result. A refusal is a result, not an
     * exception.
     *
     * @param arguments by parameter name: a Number, a double[] or List of Numbers, a String or a
     *     Boolean, in the units that the action declares
     */
    public ActResult act(String item, String action, Map<String, ?> arguments) {
        return ask(id -> Protocol.act(id, item, action, arguments), ActResult.class);
    }

    /**
     * Speaks with the voice of the agent's body, and waits for the result. Agents that hear the
     * voice find the text in {@link Perception#heard} of their next perception. A refusal is a
     * result, not an exception.
     *
     * @param text at least one word, at most 256 characters
     * @throws IllegalStateException if the client has no body
     */
    public ActResult say(String text) {
        String body =
                welcome.body()
                        .orElseThrow(
                                () ->
                                        new IllegalStateException(
                                                "this client has no body; join as an agent"));
        return act(body, Protocol.SAY, Map.of("text", text));
    }

    /**
     * Executes a command of the role control and waits for the result: pause, step, run, snapshot,
     * rewind, speed, edit, load-law, set-law, unload-law, picture, save or shut-down, with the
     * fields that the protocol defines. The value of the result of picture has the name of the file
     * as {@code file}.
     *
     * @param fields by name: a Number, a double[] or List of Numbers, a String, a Boolean, or a Map
     *     of Numbers
     */
    public ActResult command(String type, Map<String, ?> fields) {
        return ask(id -> Protocol.command(id, type, fields), ActResult.class);
    }

    /**
     * Asks a question about the world, with the fields that the protocol defines: {@code state},
     * {@code inspect}, {@code perceived} or {@code laws} in the roles observer and control, {@code
     * ledger} or {@code audit} in the role control only.
     *
     * @throws AgentException with the server's code if it refuses the question
     */
    public Report report(String type, Map<String, ?> fields) {
        return switch (ask(id -> Protocol.command(id, type, fields), ServerMessage.class)) {
            case Report report -> report;
            case ActResult refused ->
                    throw new AgentException(
                            refused.code().orElse("refused"),
                            refused.reason().orElse("the server does not answer"),
                            Optional.empty());
            case ServerMessage other -> throw AgentException.unexpected(other);
        };
    }

    /**
     * Returns a predicted perception: the perception after {@code frames} more frames if no agent
     * acts. The server computes it in a copy of the world. For the role control.
     *
     * @throws AgentException with the server's code if the number of frames is too large
     */
    public Perception foresee(int frames) {
        return foresee(frames, List.of());
    }

    /**
     * Returns a prediction like {@link #foresee(int)}, but first changes items in the copy of the
     * world.
     *
     * @param changes messages {@code add}, {@code change} and {@code remove} without id
     */
    public Perception foresee(int frames, List<? extends Map<String, ?>> changes) {
        return switch (ask(() -> talk.fork(frames, changes), ServerMessage.class)) {
            case Perception perception -> perception;
            case ActResult refused ->
                    throw new AgentException(
                            refused.code().orElse("refused"),
                            refused.reason().orElse("the server does not look ahead"),
                            Optional.empty());
            case ServerMessage other -> throw AgentException.unexpected(other);
        };
    }

    /**
     * Performs the acts in the next frame, for an agent in lock-step. Returns the perception at the
     * end of the round, with the results of the acts. A round may have several frames.
     *
     * @throws IllegalStateException if the agent is not in lock-step
     */
    public Perception step(Act... acts) {
        ready(acts);
        return observe();
    }

    /**
     * Performs the acts in the next frame and ends the agent's round, for an agent in lock-step.
     */
    public void ready(Act... acts) {
        requireLockStep();
        say(() -> talk.ready(acts));
    }

    /**
     * Waits for the newest perception that this method has not returned yet, for an agent in
     * lock-step. The world waits for the agent after the frame of this perception. The first
     * perception shows the frame in which the agent joined.
     */
    public Perception observe() {
        return observe(0);
    }

    /** Waits like {@link #observe()}, but for the perception of the given frame or a later one. */
    public Perception observe(long frame) {
        LockStep time = requireLockStep();
        Duration longest =
                patience.plus(time.deadline()).plusMillis(1000L * time.every() / welcome.rate());
        while (true) {
            synchronized (this) {
                await(() -> talk.hasObservation(frame) || talk.mustSayReady(), longest);
                if (talk.hasObservation(frame)) {
                    return talk.observation();
                }
            }
            synchronized (sending) {
                Optional<byte[]> ready;
                synchronized (this) {
                    ready = talk.mustSayReady() ? Optional.of(talk.sayReady()) : Optional.empty();
                }
                ready.ifPresent(this::send);
            }
        }
    }

    private LockStep requireLockStep() {
        return welcome.lockStep()
                .orElseThrow(
                        () ->
                                new IllegalStateException(
                                        "this agent is not in lock-step; join withLockStep"));
    }

    /** Sends a ping and waits for the pong. */
    public void ping() {
        ask(Protocol::ping, ServerMessage.Pong.class);
    }

    /**
     * Returns the events since the last call, oldest first. An event of type {@link
     * WorldEvent#MISSED} represents events that the server did not send.
     */
    public synchronized List<WorldEvent> events() {
        return talk.events();
    }

    /**
     * Returns the minimum number of events that the server did not send, see {@link
     * WorldEvent#MISSED}. The server may not know the number of events while a connection was
     * broken. These events then count as one.
     */
    public synchronized long missedEvents() {
        return talk.missedEvents();
    }

    /** Leaves the world. Further calls do nothing. */
    @Override
    public void close() {
        finish(new DisconnectedException("closed", "this agent has left", Optional.empty()));
        try {
            synchronized (sending) {
                wire.write(talk.encode(Protocol.bye()));
            }
            reader.join(patience); // the reader ends after the server's bye or a broken connection
        } catch (IOException e) {
            // The exception is ignored, because it only means that the connection has already
            // ended.
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        } finally {
            closeQuietly(wire);
        }
    }

    private <T extends ServerMessage> T ask(LongFunction<ObjectNode> build, Class<T> answerType) {
        return ask(() -> talk.question(build), answerType);
    }

    private <T extends ServerMessage> T ask(
            Supplier<Conversation.Question> ask, Class<T> answerType) {
        long id;
        synchronized (sending) {
            Conversation.Question question;
            synchronized (this) {
                requireOpen();
                question = ask.get();
            }
            id = question.id();
            send(question.line());
        }
        synchronized (this) {
            try {
                await(() -> talk.hasAnswer(id), patience);
                return talk.answer(id, answerType);
            } finally {
                talk.drop(id);
            }
        }
    }

    /** Sends a message that has no answer. */
    private void say(Supplier<byte[]> build) {
        synchronized (sending) {
            byte[] lines;
            synchronized (this) {
                requireOpen();
                lines = build.get();
            }
            send(lines);
        }
    }

    private void requireOpen() {
        if (end != null) {
            throw end;
        }
    }

    /**
     * Waits, with this object's lock held, until {@code ready} is true, the connection ends, or
     * {@code longest} has passed.
     */
    private void await(BooleanSupplier ready, Duration longest) {
        long deadline = System.nanoTime() + longest.toNanos();
        while (!ready.getAsBoolean()) {
            requireOpen();
            long left = deadline - System.nanoTime();
            if (left <= 0) {
                throw AgentException.noAnswer(longest);
            }
            try {
                TimeUnit.NANOSECONDS.timedWait(this, left);
            } catch (InterruptedException e) {
                Thread.currentThread().interrupt();
                throw new AgentException(
                        "interrupted", "the waiting thread was interrupted", Optional.empty());
            }
        }
    }

    /**
     * Sends data. The caller must hold {@link #sending}. Does nothing on a broken connection,
     * because the messages without an answer are sent again after a reconnection.
     */
    private void send(byte[] lines) {
        try {
            wire.write(lines);
        } catch (IOException e) {
            if (welcome.session().isEmpty()) {
                throw finish(lost(e));
            }
        }
    }

    /** Ends the client; only the first reason counts. */
    private synchronized AgentException finish(AgentException reason) {
        AgentException first = end == null ? reason : end;
        end = first;
        notifyAll();
        return first;
    }

    private static DisconnectedException lost(IOException cause) {
        return new DisconnectedException(
                "lost", "the connection broke: " + cause.getMessage(), Optional.empty());
    }

    // ---- methods for the reader's thread ----

    private void read() {
        try {
            while (true) {
                try {
                    take(wire.next());
                } catch (IOException e) {
                    if (!resume()) {
                        finish(lost(e));
                        return;
                    }
                } catch (DisconnectedException bye) {
                    if (!bye.code().equals(MOVED) || !follows(bye) || !resume()) {
                        throw bye;
                    }
                }
            }
        } catch (AgentException e) {
            finish(e);
        } catch (RuntimeException e) {
            // The fields of the message have wrong types.
            finish(AgentException.unreadable(e));
        }
    }

    /** Continues at the server to which another one sends the client, if it names one. */
    private boolean follows(AgentException sent) {
        if (sent instanceof DisconnectedException moved && moved.address().isPresent()) {
            address = moved.address().get();
            if (!known.contains(address)) {
                known.add(address);
            }
            return true;
        }
        return false;
    }

    private void take(ServerMessage message) {
        Optional<byte[]> reply;
        synchronized (this) {
            reply = talk.take(message);
            notifyAll();
        }
        reply.ifPresent(
                line -> {
                    synchronized (sending) {
                        send(line);
                    }
                });
    }

    /**
     * Tries to reconnect until it succeeds or the time of grace is over.
     *
     * @return true if the client is connected again
     * @throws AgentException if the server refuses the session
     */
    private boolean resume() {
        if (welcome.session().isEmpty()) {
            return false;
        }
        closeQuietly(wire);
        long deadline = System.nanoTime() + (long) (welcome.session().get().graceSeconds() * 1e9);
        while (System.nanoTime() < deadline) {
            Join greeting;
            synchronized (this) {
                if (end != null) {
                    return false;
                }
                greeting = talk.greeting().orElseThrow();
            }
            try {
                Wire.Opened opened = Wire.open(address, greeting.withPatience(attempt()));
                knowServers(opened.welcome());
                goOn(opened.wire());
                return true;
            } catch (IOException e) { // the server may have ended, and another one has the world
                takeNextServer();
                pause();
            } catch (AgentException e) {
                boolean isOut =
                        e.code().equals(CLOSING)
                                || e.code().equals(NO_ANSWER)
                                || hasEndedInHandshake(e);
                if (isOut && known.size() > 1) {
                    takeNextServer();
                    pause();
                    continue;
                }
                boolean isTemporary =
                        e.code().equals(TOO_OFTEN)
                                || e.code().equals(STARTING)
                                || e.code().equals(MOVED) && follows(e);
                if (!isTemporary) {
                    throw e;
                }
                pause();
            }
        }
        return false;
    }

    /** Returns whether a server has ended while the client and the server agreed on TLS. */
    private static boolean hasEndedInHandshake(AgentException failure) {
        Throwable handshake = failure.getCause();
        Throwable cause = handshake == null ? null : handshake.getCause();
        return failure.code().equals(Wire.TLS_FAILED)
                && (cause instanceof EOFException || cause instanceof SocketException);
    }

    private Duration attempt() {
        return known.size() > 1 && patience.compareTo(ATTEMPT) > 0 ? ATTEMPT : patience;
    }

    /** Notes the servers at which the session can be resumed. */
    private void knowServers(Welcome told) {
        for (String server : told.session().map(Welcome.Ticket::servers).orElse(List.of())) {
            InetSocketAddress other = DisconnectedException.parsed(server);
            if (!known.contains(other)) {
                known.add(other);
            }
        }
    }

    private void takeNextServer() {
        address = known.get((known.indexOf(address) + 1) % known.size());
    }

    private void goOn(Wire next) {
        synchronized (sending) {
            wire = next;
            byte[] lines;
            synchronized (this) {
                lines = end == null ? talk.goneOn() : talk.encode(Protocol.bye());
            }
            send(lines);
        }
    }

    /** Waits until the next attempt, or until the client is closed. */
    private synchronized void pause() {
        if (end == null) {
            try {
                TimeUnit.MILLISECONDS.timedWait(this, RETRY.toMillis());
            } catch (InterruptedException e) {
                Thread.currentThread().interrupt();
            }
        }
    }

    private static void closeQuietly(Wire old) {
        try {
            old.close();
        } catch (IOException e) {
            // The exception is ignored, because close() frees the descriptor even if it fails.
        }
    }
}
