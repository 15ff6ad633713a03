package reve.agent;

import java.io.BufferedInputStream;
import java.io.ByteArrayOutputStream;
import java.io.DataInputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.net.SocketTimeoutException;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Deque;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.concurrent.TimeUnit;
import java.util.function.BooleanSupplier;
import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLException;
import javax.net.ssl.SSLParameters;
import javax.net.ssl.SSLSocket;
import org.jspecify.annotations.Nullable;
import tools.jackson.databind.node.ObjectNode;

/**
 * An agent in a world. Calls block until the server has answered; a thread of the client's own reads, so that the
 * server's pings are answered while the agent thinks. Methods may be called from any thread.
 *
 * <p>Every call throws {@link DisconnectedException} once the connection has ended, and {@link AgentException} with
 * code {@code no-answer} if the server is silent for longer than the patience.
 */
public final class AgentClient implements AutoCloseable {

    /** How many events wait for {@link #events()}; older ones are forgotten. */
    public static final int MAX_EVENTS = 1024;

    private static final long NO_FRAME = -1;

    private final Socket socket;
    private final DataInputStream in;
    private final Encoding encoding;
    private final OutputStream out;
    private final Duration patience;
    private final Welcome welcome;
    private final Thread reader;
    private final Object sending = new Object();

    // Guarded by this.
    private final Map<Long, Optional<ServerMessage>> answers = new HashMap<>();
    private final Deque<WorldEvent> events = new ArrayDeque<>();
    private long lastId;
    private long subscription;
    private int every;
    private @Nullable Perception known;
    private @Nullable Perception latest;
    /** Acts of the round, in lock-step. */
    private List<Long> doing = List.of();
    private long readyFrame = NO_FRAME;
    private long observedFrame = NO_FRAME;
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
        var socket = new Socket();
        try {
            int patience = Math.toIntExact(join.patience().toMillis());
            socket.connect(new InetSocketAddress(host, port), patience);
            socket.setSoTimeout(patience);
            return new AgentClient(join.tls().isPresent() ? secure(socket, host, join.tls().get()) : socket, join);
        } catch (SSLException e) {
            socket.close();
            throw new DisconnectedException("tls-failed", e.getMessage(),
                    Optional.of("does the server speak TLS, and is its certificate one that you trust?"));
        } catch (IOException | RuntimeException e) {
            socket.close();
            throw e;
        }
    }

    /** Shakes hands, and makes sure that the server is the one at that address. */
    private static Socket secure(Socket socket, String host, SSLContext trusted) throws IOException {
        var secure = (SSLSocket) trusted.getSocketFactory().createSocket(socket, host, socket.getPort(), true);
        SSLParameters parameters = secure.getSSLParameters();
        parameters.setEndpointIdentificationAlgorithm("HTTPS");
        secure.setSSLParameters(parameters);
        secure.startHandshake();
        return secure;
    }

    private AgentClient(Socket socket, Join join) throws IOException {
        this.socket = socket;
        this.patience = join.patience();
        socket.setTcpNoDelay(true);
        in = new DataInputStream(new BufferedInputStream(socket.getInputStream()));
        out = socket.getOutputStream();
        encoding = join.encoding();
        write(encode(Protocol.hello(join), Encoding.JSON));
        welcome = awaitWelcome();
        socket.setSoTimeout(0);
        reader = Thread.ofVirtual().name("reve agent " + join.name()).start(this::read);
    }

    /** What the server said when the agent joined: its body, the world, the limits. */
    public Welcome welcome() {
        return welcome;
    }

    /** The items of the next frame. */
    public Perception perceive() {
        long id = nextId();
        return ask(id, Protocol.perceive(id), Perception.class);
    }

    /**
     * The items of the next frame; the symbols of bodies with a shape hold {@code near}, {@code on}, {@code inside}
     * and {@code touching}, too.
     */
    public Perception perceiveWithRelations() {
        long id = nextId();
        return ask(id, Protocol.perceiveWithRelations(id), Perception.class);
    }

    /**
     * Asks for a perception every that many frames from now on, for {@link #nextPerception()}.
     *
     * @throws IllegalStateException in lock-step, where the agent perceives its rounds
     */
    public void perceiveEvery(int frames) {
        if (welcome.lockStep().isPresent()) {
            throw new IllegalStateException("an agent in lock-step perceives its rounds: use observe or step");
        }
        if (frames < 1) {
            throw new IllegalArgumentException("every " + frames + " frames, expected 1 or more");
        }
        long id = nextId();
        synchronized (this) {
            subscription = id;
            every = frames;
            known = null;
            latest = null;
        }
        send(Protocol.perceive(id, frames));
    }

    /**
     * Waits for the newest perception that the agent has not seen: who is slow skips some, and never gets old ones.
     *
     * @throws IllegalStateException without {@link #perceiveEvery}
     */
    public synchronized Perception nextPerception() {
        if (subscription == 0) {
            throw new IllegalStateException("call perceiveEvery before nextPerception");
        }
        await(() -> latest != null, patience.plusMillis(1000L * every / welcome.rate()));
        Perception perception = Objects.requireNonNull(latest);
        latest = null;
        return perception;
    }

    /** Ends what {@link #perceiveEvery} began. */
    public void stopPerceiving() {
        synchronized (this) {
            if (subscription == 0) {
                return;
            }
            subscription = 0;
            known = null;
            latest = null;
        }
        send(Protocol.perceive(nextId(), 0));
    }

    /**
     * What one of the body's cameras sees now.
     *
     * @throws AgentException with the server's code if there is no picture
     */
    public Image look(String sensor) {
        long id = nextId();
        return ask(id, Protocol.look(id, sensor), Image.class);
    }

    /**
     * Asks an item to do one of its actions and waits for the outcome. A refusal is a result, no exception.
     *
     * @param arguments by parameter name: a Number, a double[] or List of Numbers, a String or a Boolean, in the
     *     units that the action declares
     */
    public ActResult act(String item, String action, Map<String, ?> arguments) {
        long id = nextId();
        return ask(id, Protocol.act(id, item, action, arguments), ActResult.class);
    }

    /**
     * Has a command of the role control done and waits for the outcome: pause, step, run, snapshot, rewind, edit,
     * load-law, unload-law, picture, save or shut-down, with the fields that the protocol's page lists.
     *
     * @param fields by name: a Number, a double[] or List of Numbers, a String, a Boolean, or a Map of Numbers
     */
    public ActResult command(String type, Map<String, ?> fields) {
        long id = nextId();
        return ask(id, Protocol.command(id, type, fields), ActResult.class);
    }

    /**
     * What would be perceived that many frames from now, if nobody did anything; for the role control.
     *
     * @throws AgentException with the server's code if it refuses to look so far ahead
     */
    public Perception foresee(int frames) {
        long id = nextId();
        ServerMessage answer = ask(id, Protocol.command(id, "fork", Map.of("frames", frames)), ServerMessage.class);
        return switch (answer) {
            case Perception perception -> perception;
            case ActResult refused -> throw new AgentException(refused.code().orElse("refused"),
                    refused.reason().orElse("the server does not look ahead"), Optional.empty());
            default -> throw unexpected(answer);
        };
    }

    // ---- lock-step ----

    /**
     * In lock-step: does these things in the next frame and returns what is perceived then, or at the end of a round of
     * several frames, with the results.
     *
     * @throws IllegalStateException if the agent is not in lock-step
     */
    public Perception step(Act... acts) {
        ready(acts);
        return observe();
    }

    /** In lock-step: does these things in the next frame, for which the world need not wait any longer. */
    public void ready(Act... acts) {
        requireLockStep();
        var messages = new ArrayList<ObjectNode>();
        synchronized (this) {
            OptionalLong seen = known == null ? OptionalLong.empty() : OptionalLong.of(known.frame());
            List<Long> ids = Arrays.stream(acts).map(act -> nextId()).toList();
            for (int i = 0; i < acts.length; i++) {
                String item = acts[i].item().orElseGet(() -> welcome.body().orElseThrow());
                ObjectNode act = Protocol.act(ids.get(i), item, acts[i].action(), acts[i].arguments());
                messages.add(i == acts.length - 1 ? Protocol.andReady(act, seen) : act);
            }
            if (acts.length == 0) {
                messages.add(Protocol.ready(seen));
            }
            doing.forEach(answers::remove);
            doing = ids;
            ids.forEach(id -> answers.put(id, Optional.empty()));
            readyFrame = seen.orElse(NO_FRAME);
        }
        messages.forEach(this::send);
    }

    /**
     * In lock-step: waits for the newest perception that was not observed yet, after which the world waits for the
     * agent. The first is that of the frame that it joined in.
     */
    public Perception observe() {
        return observe(0);
    }

    /** As {@link #observe()}, of that frame or a later one. */
    public Perception observe(long frame) {
        LockStep time = requireLockStep();
        Duration longest = patience.plus(time.deadline()).plusMillis(1000L * time.every() / welcome.rate());
        while (true) {
            OptionalLong missed;
            synchronized (this) {
                await(() -> isObservable(frame) || isWaitedForAgain(), longest);
                if (isObservable(frame)) {
                    return observation();
                }
                readyFrame = Objects.requireNonNull(known).frame();
                missed = OptionalLong.of(readyFrame);
            }
            send(Protocol.ready(missed));
        }
    }

    private boolean isObservable(long frame) {
        return known != null && known.frame() > observedFrame && known.frame() >= frame && isAllDone();
    }

    /** The round went on without the agent, and the next one waits while results are still to come. */
    private boolean isWaitedForAgain() {
        return known != null && known.frame() > readyFrame && !isAllDone();
    }

    private boolean isAllDone() {
        return doing.stream().allMatch(id -> answers.get(id).isPresent());
    }

    private Perception observation() {
        Perception seen = Objects.requireNonNull(known);
        observedFrame = seen.frame();
        List<ServerMessage> done = doing.stream().map(id -> answers.remove(id).orElseThrow()).toList();
        doing = List.of();
        var results = new ArrayList<ActResult>();
        for (ServerMessage answer : done) {
            switch (answer) {
                case ActResult result -> results.add(result);
                case ServerMessage.Error error -> throw refused(error);
                default -> throw unexpected(answer);
            }
        }
        return seen.with(List.copyOf(results));
    }

    private LockStep requireLockStep() {
        return welcome.lockStep().orElseThrow(() -> new IllegalStateException(
                "nobody waits for this agent; join withLockStep"));
    }

    /** Returns when the server has answered. */
    public void ping() {
        long id = nextId();
        ask(id, Protocol.ping(id), ServerMessage.Pong.class);
    }

    /** What happened since the last call, oldest first. */
    public synchronized List<WorldEvent> events() {
        List<WorldEvent> news = List.copyOf(events);
        events.clear();
        return news;
    }

    /** Leaves the world. Calling it again does nothing. */
    @Override
    public void close() {
        finish(new DisconnectedException("closed", "this agent has left", Optional.empty()));
        try (socket) {
            write(Protocol.bye());
            reader.join(patience); // ends with the server's bye, or with the connection
        } catch (IOException e) {
            // The connection is gone already, which is all we want.
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        }
    }

    // ---- asking ----

    private synchronized long nextId() {
        return ++lastId;
    }

    private <T extends ServerMessage> T ask(long id, ObjectNode question, Class<T> answerType) {
        ServerMessage answer;
        synchronized (this) {
            answers.put(id, Optional.empty());
        }
        try {
            send(question);
            answer = awaitAnswer(id);
        } finally {
            synchronized (this) {
                answers.remove(id);
            }
        }
        if (answer instanceof ServerMessage.Error error) {
            throw refused(error);
        }
        if (!answerType.isInstance(answer)) {
            throw unexpected(answer);
        }
        return answerType.cast(answer);
    }

    private synchronized ServerMessage awaitAnswer(long id) {
        await(() -> answers.get(id).isPresent(), patience);
        return answers.get(id).orElseThrow();
    }

    /** With this held: until ready, or the end of the connection or of patience. */
    private void await(BooleanSupplier ready, Duration longest) {
        long deadline = System.nanoTime() + longest.toNanos();
        while (!ready.getAsBoolean()) {
            if (end != null) {
                throw end;
            }
            long left = deadline - System.nanoTime();
            if (left <= 0) {
                throw noAnswer(longest);
            }
            try {
                TimeUnit.NANOSECONDS.timedWait(this, left);
            } catch (InterruptedException e) {
                Thread.currentThread().interrupt();
                throw new AgentException("interrupted", "the waiting thread was interrupted", Optional.empty());
            }
        }
    }

    private void send(ObjectNode message) {
        synchronized (this) {
            if (end != null) {
                throw end;
            }
        }
        try {
            write(message);
        } catch (IOException e) {
            throw finish(lost(e));
        }
    }

    private void write(ObjectNode message) throws IOException {
        write(encode(message, encoding));
    }

    private void write(byte[] message) throws IOException {
        synchronized (sending) {
            out.write(message);
            out.flush();
        }
    }

    private static byte[] encode(ObjectNode message, Encoding encoding) {
        return encoding == Encoding.JSON ? (message + "\n").getBytes(StandardCharsets.UTF_8) : Packed.write(message);
    }

    // ---- listening ----

    private Welcome awaitWelcome() throws IOException {
        try {
            ServerMessage message = next();
            while (!(message instanceof Welcome greeting)) {
                switch (message) {
                    case ServerMessage.Ping ping -> write(Protocol.pong());
                    case ServerMessage.Bye bye -> throw disconnected(bye);
                    case ServerMessage.Error error -> throw refused(error);
                    default -> throw unexpected(message);
                }
                message = next();
            }
            return greeting;
        } catch (SocketTimeoutException e) {
            throw noAnswer(patience);
        }
    }

    private void read() {
        try {
            while (true) {
                take(next());
            }
        } catch (IOException e) {
            finish(lost(e));
        } catch (AgentException e) {
            finish(e);
        }
    }

    /** A line of JSON begins with a brace, a length with 0. */
    private ServerMessage next() throws IOException {
        int first = in.read();
        if (first < 0) {
            throw new DisconnectedException("lost", "the server closed the connection without a reason",
                    Optional.empty());
        }
        if (first != 0) {
            return Protocol.read(line(first));
        }
        byte[] packed = new byte[in.readUnsignedByte() << 16 | in.readUnsignedShort()];
        in.readFully(packed);
        return Protocol.read(packed);
    }

    private String line(int first) throws IOException {
        var line = new ByteArrayOutputStream(256);
        for (int next = first; next >= 0 && next != '\n'; next = in.read()) {
            line.write(next);
        }
        return line.toString(StandardCharsets.UTF_8);
    }

    private void take(ServerMessage message) throws IOException {
        switch (message) {
            case ServerMessage.Ping ping -> write(Protocol.pong());
            case ServerMessage.Bye bye -> throw disconnected(bye);
            case ServerMessage.Pong pong -> answer(pong.id(), pong);
            case ServerMessage.Error error -> {
                if (error.id().isEmpty()) {
                    throw refused(error);
                }
                answer(error.id(), error);
            }
            case Image image -> answer(OptionalLong.of(image.id()), image);
            case ActResult result -> answer(OptionalLong.of(result.id()), result);
            case Perception perception -> show(perception);
            case Update update -> show(update);
            case WorldEvent event -> remember(event);
            case Welcome again -> throw unexpected(again);
        }
    }

    private synchronized void show(Perception perception) {
        if (perception.id().equals(stream())) {
            known = perception;
            latest = perception;
            notifyAll();
        } else {
            answer(perception.id(), perception);
        }
    }

    private synchronized void show(Update update) {
        if (known != null && update.id().equals(stream())) {
            known = known.updated(update);
            latest = known;
            notifyAll();
        }
    }

    /** In lock-step perceptions come without having been asked for. */
    private OptionalLong stream() {
        return welcome.lockStep().isPresent() ? OptionalLong.empty() : OptionalLong.of(subscription);
    }

    private synchronized void answer(OptionalLong id, ServerMessage message) {
        if (id.isPresent()) {
            answers.computeIfPresent(id.getAsLong(), (number, none) -> Optional.of(message));
            notifyAll();
        }
    }

    private synchronized void remember(WorldEvent event) {
        if (events.size() == MAX_EVENTS) {
            events.removeFirst();
        }
        events.addLast(event);
    }

    /** The first reason counts. */
    private synchronized AgentException finish(AgentException reason) {
        AgentException first = end == null ? reason : end;
        end = first;
        notifyAll();
        return first;
    }

    // ---- what goes wrong ----

    private static DisconnectedException disconnected(ServerMessage.Bye bye) {
        return new DisconnectedException(bye.code(), bye.message(), bye.hint());
    }

    private static DisconnectedException lost(IOException cause) {
        return new DisconnectedException("lost", "the connection broke: " + cause.getMessage(), Optional.empty());
    }

    private static AgentException refused(ServerMessage.Error error) {
        return new AgentException(error.code(), error.message(), error.hint());
    }

    private static AgentException unexpected(ServerMessage message) {
        return new AgentException("protocol", "the server sent what nobody asked for: " + message, Optional.empty());
    }

    private static AgentException noAnswer(Duration waited) {
        return new AgentException("no-answer", "the server was silent for " + waited.toMillis() / 1000.0 + " s",
                Optional.of("is its world running?"));
    }
}
