// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import org.jspecify.annotations.Nullable;

import tools.jackson.databind.node.ObjectNode;

import java.io.EOFException;
import java.io.IOException;
import java.net.InetSocketAddress;
import java.time.Duration;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.TimeUnit;
import java.util.function.BooleanSupplier;
import java.util.function.LongFunction;
import java.util.function.Supplier;

/**
 * An agent in a world. Calls block until the server has answered; a thread of the client's own
 * reads, so that the server's pings are answered while the agent thinks. Methods may be called from
 * any thread.
 *
 * <p>With {@link Join#withGrace} the client goes on by itself over another connection when one
 * breaks: whoever waits for an answer gets it, and no action is done twice.
 *
 * <p>Every call throws {@link DisconnectedException} once the connection has ended, and {@link
 * AgentException} with code {@code no-answer} if the server is silent for longer than the patience.
 */
public final class AgentClient implements AutoCloseable {

    /** How many events wait for {@link #events()}; older ones are forgotten. */
    public static final int MAX_EVENTS = 1024;

    private static final Duration RETRY = Duration.ofMillis(200);

    /** Code of a refused resume that may be repeated later. */
    private static final String TOO_OFTEN = "resumed-too-often";

    private final InetSocketAddress address;
    private final Duration patience;
    private final Welcome welcome;
    private final Thread reader;

    /** Held while something is sent; taken before this. */
    private final Object sending = new Object();

    /** Replaced by the reader, with {@link #sending} held. */
    private volatile Wire wire;

    // Guarded by this.
    private final Conversation talk;
    private @Nullable AgentException end;

    /**
     * Joins the world at an address, with a body that the world chooses.
     *
     * @throws IOException if nobody listens there
     * @throws DisconnectedException with the server's code if the agent may not join
     */
    public static AgentClient connect(String host, int port, String name) throws IOException {
        return connect(host, port, Join.as(name));
    }

    /** As {@link #connect(String, int, String)}, in any role. */
    public static AgentClient connect(String host, int port, Join join) throws IOException {
        return new AgentClient(InetSocketAddress.createUnresolved(host, port), join);
    }

    private AgentClient(InetSocketAddress address, Join join) throws IOException {
        this.address = address;
        this.patience = join.patience();
        Wire.Opened opened = open(address, join);
        wire = opened.wire();
        welcome = opened.welcome();
        talk = new Conversation(join, welcome);
        reader = Thread.ofVirtual().name("reve agent " + join.name()).start(this::read);
    }

    private static Wire.Opened open(InetSocketAddress address, Join join) throws IOException {
        try {
            return Wire.open(address, join);
        } catch (EOFException e) {
            throw lost(e);
        }
    }

    /** What the server said when the agent joined: its body, the world, the limits. */
    public Welcome welcome() {
        return welcome;
    }

    /** The items of the next frame. */
    public Perception perceive() {
        return ask(Protocol::perceive, Perception.class);
    }

    /**
     * The items of the next frame; the symbols of bodies with a shape hold {@code near}, {@code
     * on}, {@code inside} and {@code touching}, too.
     */
    public Perception perceiveWithRelations() {
        return ask(Protocol::perceiveWithRelations, Perception.class);
    }

    /**
     * Asks for a perception every that many frames from now on, for {@link #nextPerception()}.
     *
     * @throws IllegalStateException in lock-step, where the agent perceives its rounds
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
     * Waits for the newest perception that the agent has not seen: who is slow skips some, and
     * never gets old ones.
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

    /** Ends what {@link #perceiveEvery} began. */
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
     * What one of the body's cameras sees now.
     *
     * @throws AgentException with the server's code if there is no picture
     */
    public Image look(String sensor) {
        return ask(id -> Protocol.look(id, sensor), Image.class);
    }

    /**
     * Asks an item to do one of its actions and waits for the outcome. A refusal is a result, no
     * exception.
     *
     * @param arguments by parameter name: a Number, a double[] or List of Numbers, a String or a
     *     Boolean, in the units that the action declares
     */
    public ActResult act(String item, String action, Map<String, ?> arguments) {
        return ask(id -> Protocol.act(id, item, action, arguments), ActResult.class);
    }

    /**
     * Has a command of the role control done and waits for the outcome: pause, step, run, snapshot,
     * rewind, edit, load-law, unload-law, picture, save or shut-down, with the fields that the
     * protocol's page lists.
     *
     * @param fields by name: a Number, a double[] or List of Numbers, a String, a Boolean, or a Map
     *     of Numbers
     */
    public ActResult command(String type, Map<String, ?> fields) {
        return ask(id -> Protocol.command(id, type, fields), ActResult.class);
    }

    /**
     * What would be perceived that many frames from now, if nobody did anything; for the role
     * control.
     *
     * @throws AgentException with the server's code if it refuses to look so far ahead
     */
    public Perception foresee(int frames) {
        return switch (ask(() -> talk.fork(frames), ServerMessage.class)) {
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
     * In lock-step: does these things in the next frame and returns what is perceived then, or at
     * the end of a round of several frames, with the results.
     *
     * @throws IllegalStateException if the agent is not in lock-step
     */
    public Perception step(Act... acts) {
        ready(acts);
        return observe();
    }

    /**
     * In lock-step: does these things in the next frame, for which the world need not wait any
     * longer.
     */
    public void ready(Act... acts) {
        requireLockStep();
        say(() -> talk.ready(acts));
    }

    /**
     * In lock-step: waits for the newest perception that was not observed yet, after which the
     * world waits for the agent. The first is that of the frame that it joined in.
     */
    public Perception observe() {
        return observe(0);
    }

    /** As {@link #observe()}, of that frame or a later one. */
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
                                        "nobody waits for this agent; join withLockStep"));
    }

    /** Returns when the server has answered. */
    public void ping() {
        ask(Protocol::ping, ServerMessage.Pong.class);
    }

    /**
     * What happened since the last call, oldest first. A {@link WorldEvent#MISSED} stands for those
     * that the server did not send.
     */
    public synchronized List<WorldEvent> events() {
        return talk.events();
    }

    /**
     * How many events the server did not send, see {@link WorldEvent#MISSED}. At least: of what
     * happened while a connection was broken it may not know how many, and counts one.
     */
    public synchronized long missedEvents() {
        return talk.missedEvents();
    }

    /** Leaves the world. Calling it again does nothing. */
    @Override
    public void close() {
        finish(new DisconnectedException("closed", "this agent has left", Optional.empty()));
        try {
            synchronized (sending) {
                wire.write(talk.encode(Protocol.bye()));
            }
            reader.join(patience); // ends with the server's bye, or with the connection
        } catch (IOException e) {
            // The connection is gone already, which is all we want.
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

    /** Sends what has no answer of its own. */
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

    /** With this held: until ready, or the end of the connection or of patience. */
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
     * With {@link #sending} held. Over a broken connection nothing: what matters is said again over
     * the next.
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

    /** The first reason counts. */
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

    // Methods for the reader's thread.

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
                }
            }
        } catch (AgentException e) {
            finish(e);
        }
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
     * Goes on over another connection, until the time of grace is over.
     *
     * @return true if that worked
     * @throws AgentException if the server refuses for good
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
                goOn(Wire.open(address, greeting).wire());
                return true;
            } catch (IOException e) {
                pause();
            } catch (AgentException e) {
                if (!e.code().equals(TOO_OFTEN)) {
                    throw e;
                }
                pause();
            }
        }
        return false;
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

    /** Until it is time to try again, or the client is closed. */
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
            // Closing frees the descriptor even when it complains.
        }
    }
}
