// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.frame.Pacing;

import java.io.Closeable;
import java.io.IOException;
import java.net.BindException;
import java.net.InetSocketAddress;
import java.net.SocketAddress;
import java.net.StandardSocketOptions;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.regex.Pattern;
import java.util.stream.Collectors;
import java.util.stream.Stream;

/**
 * Lets agents join worlds over TCP, protocol version 1. Each world goes on at its own pace whatever
 * agents do; they come and go at any time. Its methods may be called from any thread.
 */
public final class AgentServer implements AutoCloseable {

    /** The protocol version it speaks. */
    public static final int PROTOCOL = 1;

    private static final Pattern NAME = Pattern.compile("[A-Za-z0-9][A-Za-z0-9_.-]{0,63}");
    private static final int BACKLOG = 512;
    private static final int CHECKS_PER_DEADLINE = 4;

    /** So that a flood of connections does not keep the others waiting. */
    private static final int ACCEPTED_PER_TURN = 16;

    /** Least time between two looks at clients that have sent all that they may. */
    private static final long THROTTLE_NANOS = 10_000_000;

    private final AgentServerConfig config;
    private final Counters counters = new Counters();
    private final RateLimitedLog log = new RateLimitedLog(10, "agents");

    /** Of its own, so that a flood of connections hides nothing that is said of agents. */
    private final RateLimitedLog strangersLog =
            new RateLimitedLog(1, "clients that have not said hello");

    private final List<ServedWorld> worlds;
    private final EventLoop loop;
    private final ServerSocketChannel listening;
    private final InetSocketAddress address;
    private final SelectionKey accepting;

    /** The event loop's own. */
    private final Set<Connection> connections = new HashSet<>();

    private final Strangers strangers;
    private final Writers writers = new Writers(Runtime.getRuntime().availableProcessors());
    private final SlowReaders<Connection> slowReaders = new SlowReaders<>();

    /** They have sent all that they may. The event loop's own. */
    private List<Connection> throttled = new ArrayList<>();

    private long readThrottledNanos = System.nanoTime();
    private final Optional<AuditLog> audit;

    /** The event loop's own, as long as it runs. */
    private final List<FileProblem> fileProblems;

    private final Attempts attempts = new Attempts();

    /** Sessions without a token that wait for their client to come back. Guarded by itself. */
    private final Set<Session> kept = new HashSet<>();

    private volatile boolean closed;

    /**
     * Begins to listen.
     *
     * @param ports of worlds of different names, at least one
     * @param problems receives what is wrong with the server's files while it runs
     * @throws BindException naming the address if it cannot be had
     * @throws IOException if the audit file cannot be written
     */
    public static AgentServer start(
            AgentServerConfig config, List<WorldPort> ports, ServerProblems problems)
            throws IOException {
        ServerSocketChannel listening = listen(config.address());
        try {
            var server = new AgentServer(config, ports, listening, openAudit(config), problems);
            server.loop.start();
            server.writers.start();
            return server;
        } catch (IOException e) {
            closeQuietly(listening);
            throw e;
        }
    }

    private static Optional<AuditLog> openAudit(AgentServerConfig config) throws IOException {
        return config.audit().isPresent()
                ? Optional.of(new AuditLog(config.audit().get()))
                : Optional.empty();
    }

    private AgentServer(
            AgentServerConfig config,
            List<WorldPort> ports,
            ServerSocketChannel listening,
            Optional<AuditLog> audit,
            ServerProblems problems)
            throws IOException {
        this.audit = audit;
        this.config = config;
        this.fileProblems = fileProblems(config.security(), audit, problems);
        int all = config.limits().maxConnections();
        this.strangers = new Strangers(all - all / 4);
        this.listening = listening;
        this.address =
                new InetSocketAddress(
                        config.address().getAddress(),
                        ((InetSocketAddress) listening.getLocalAddress()).getPort());
        this.loop =
                new EventLoop(
                        log, new LoopWork(), shortest(config.timeouts()) / CHECKS_PER_DEADLINE);
        this.accepting = loop.register(listening, SelectionKey.OP_ACCEPT, key -> accept());
        // A world in real time has frames to make while agents are served; so do others beside it.
        boolean helps = ports.size() == 1 && ports.getFirst().loop().pacing() == Pacing.FAST;
        this.worlds =
                ports.stream()
                        .map(
                                port ->
                                        new ServedWorld(
                                                this, port, helps ? loop : LockStep.Waiting.IDLE))
                        .toList();
    }

    private static List<FileProblem> fileProblems(
            AgentSecurity security, Optional<AuditLog> audit, ServerProblems listener) {
        var problems = new ArrayList<FileProblem>();
        audit.ifPresent(
                log -> problems.add(new FileProblem("audit", log::problem, log::solved, listener)));
        security.tokens()
                .ifPresent(
                        tokens ->
                                problems.add(
                                        new FileProblem(
                                                "tokens",
                                                tokens::problem,
                                                tokens::solved,
                                                listener)));
        security.tls()
                .ifPresent(
                        tls ->
                                problems.add(
                                        new FileProblem(
                                                "tls", tls::problem, tls::solved, listener)));
        return List.copyOf(problems);
    }

    private static long shortest(AgentTimeouts timeouts) {
        return Stream.of(
                        timeouts.hello(),
                        timeouts.line(),
                        timeouts.idle(),
                        timeouts.write(),
                        timeouts.linger())
                .mapToLong(Duration::toNanos)
                .min()
                .orElseThrow();
    }

    /** Where it listens, with the port it got. */
    public InetSocketAddress address() {
        return address;
    }

    public AgentStats stats() {
        return counters.read(audit.map(AuditLog::unrecorded).orElse(0L));
    }

    /** A world makes no more frames: says bye to everybody who is in it, and lets nobody in. */
    public void end(String world) {
        loop.later(() -> meant(Optional.of(world)).forEach(ServedWorld::end));
    }

    /**
     * Says bye to everybody and returns when all are gone, at the latest after the time to linger.
     */
    @Override
    public void close() {
        if (closed) {
            return;
        }
        worlds.forEach(ServedWorld::close);
        loop.later(
                () -> {
                    closed = true;
                    closeQuietly(listening);
                    connections.forEach(
                            connection ->
                                    connection.end(Ending.regular("closing", "the server ends")));
                });
        try {
            if (!loop.join(2 * config.timeouts().linger().toMillis())) {
                loop.stop();
            }
        } catch (InterruptedException e) {
            loop.stop();
            Thread.currentThread().interrupt();
        }
        writers.stop();
        fileProblems.forEach(FileProblem::check);
        audit.ifPresent(AgentServer::closeQuietly);
    }

    /** What the event loop does in every turn, after it has read. */
    private final class LoopWork implements EventLoop.Work {

        @Override
        public boolean isWaiting() {
            return writers.isWaiting() || hasNews();
        }

        private boolean hasNews() {
            for (ServedWorld world : worlds) {
                if (world.publisher().hasWork()) {
                    return true;
                }
            }
            return false;
        }

        @Override
        public void run() {
            for (ServedWorld world : worlds) {
                if (world.publisher().hasWork()) {
                    world.publisher().tell();
                    readThrottled();
                }
            }
            writers.writeAll();
            slowReaders.excess().forEach(Connection::giveUp);
            if (closed && connections.isEmpty()) {
                loop.stop();
            }
        }

        @Override
        public void checkDeadlines(long nowNanos) {
            List.copyOf(connections).forEach(connection -> connection.checkDeadlines(nowNanos));
            worlds.forEach(world -> world.checkGrace(nowNanos));
            readThrottled();
            config.security().tls().ifPresent(ServerTls::refresh);
            fileProblems.forEach(FileProblem::check);
            config.security()
                    .tokens()
                    .map(TokenFile::current)
                    .ifPresent(current -> worlds.forEach(world -> world.checkTokens(current)));
            if (accepting.isValid()) {
                accepting.interestOps(SelectionKey.OP_ACCEPT);
            }
        }
    }

    /** Not in every turn: many a frame of a fast world goes by before they may send much more. */
    private void readThrottled() {
        long now = System.nanoTime();
        if (throttled.isEmpty() || now - readThrottledNanos < THROTTLE_NANOS) {
            return;
        }
        readThrottledNanos = now;
        List<Connection> those = throttled;
        throttled = new ArrayList<>();
        those.forEach(Connection::readAgain);
    }

    // ---- for connections and sessions ----

    EventLoop loop() {
        return loop;
    }

    void wake() {
        loop.wake();
    }

    /** What the event loop writes with. */
    Pen pen() {
        return writers.pen();
    }

    /** The connections that do not read what was written to them. */
    SlowReaders<Connection> slowReaders() {
        return slowReaders;
    }

    /** Has what waits for a client written in this turn. */
    void writeSoon(Connection connection) {
        writers.add(connection);
        loop.wake();
    }

    /** Has it read again in a while: with news, which a frame is, or when deadlines are checked. */
    void readLater(Connection connection) {
        throttled.add(connection);
    }

    AgentServerConfig config() {
        return config;
    }

    Counters counters() {
        return counters;
    }

    RateLimitedLog log() {
        return log;
    }

    /** About connections that have not said hello. */
    RateLimitedLog strangersLog() {
        return strangersLog;
    }

    Optional<AuditLog> audit() {
        return audit;
    }

    /**
     * Lets a client in, or lets it go on where its last connection broke.
     *
     * @return its session; the welcome comes when the world has taken it
     * @throws Ending if it cannot come in
     */
    Session greet(Connection connection, ClientMessage.Hello hello) throws Ending {
        Role role = requireAcceptable(hello);
        if (hello.resume().isPresent()) {
            return resume(connection, hello, hello.resume().get());
        }
        Optional<AgentToken> token = requireToken(connection, hello);
        requireRecord();
        Rights rights = token.map(AgentToken::rights).orElse(Rights.ALL);
        ServedWorld world = requireWorld(hello.world(), rights);
        requireOpen(hello, role, token, world);
        int clients = worlds.stream().mapToInt(ServedWorld::clients).sum();
        if (clients >= config.limits().maxConnections()) {
            throw full(); // those that wait for their client count, too
        }
        return world.greet(connection, role, hello, token);
    }

    private void requireRecord() throws Ending {
        if (audit.isPresent() && !audit.get().isServing()) {
            throw notRecorded();
        }
    }

    /** The server may send nothing without a record. */
    static Ending notRecorded() {
        return Ending.refused(
                "not-recorded",
                "the server sends nothing without a record, and cannot write it now",
                "try again later");
    }

    private Session resume(
            Connection connection, ClientMessage.Hello hello, ClientMessage.Resume resume)
            throws Ending {
        Optional<Session> found =
                meant(hello.world()).stream()
                        .flatMap(world -> world.find(hello.name()).stream())
                        .filter(session -> session.hasSecret(resume.session()))
                        .findFirst();
        if (found.isEmpty()) {
            countWrong(connection);
            throw Ending.refused(
                    "no-such-session",
                    "there is no session of "
                            + Text.quote(hello.name())
                            + " with this token, or it has ended",
                    "say hello without resume");
        }
        requireRecord();
        found.get().resume(connection, resume.frame());
        return found.get();
    }

    /** The world that is named, or the only one that is open to the client. */
    private ServedWorld requireWorld(Optional<String> name, Rights rights) throws Ending {
        List<ServedWorld> open =
                meant(Optional.empty()).stream()
                        .filter(world -> rights.opensWorld(world.name()))
                        .toList();
        List<ServedWorld> meant = name.isPresent() || open.isEmpty() ? meant(name) : open;
        if (meant.size() == 1) {
            return meant.getFirst();
        }
        String problem =
                name.map(unknown -> "this server has no world " + Text.quote(unknown))
                        .orElse("this server has " + open.size() + " worlds");
        String names =
                open.stream()
                        .map(world -> Text.quote(world.name()))
                        .collect(Collectors.joining(" or "));
        throw Ending.refused("no-such-world", problem, "say hello with \"world\": " + names);
    }

    /** The worlds of that name, or all; not those that have ended. */
    private List<ServedWorld> meant(Optional<String> name) {
        return worlds.stream()
                .filter(world -> !world.hasEnded())
                .filter(world -> name.isEmpty() || name.get().equals(world.name()))
                .toList();
    }

    /** What the client's token says it may; nothing where the server asks for none. */
    private Optional<AgentToken> requireToken(Connection connection, ClientMessage.Hello hello)
            throws Ending {
        if (config.security().tokens().isEmpty()) {
            return Optional.empty();
        }
        Optional<AgentToken> token =
                config.security().tokens().get().find(hello.token().orElse(""));
        if (token.isEmpty()) {
            countWrong(connection);
            throw Ending.refused(
                    "bad-token",
                    "this server takes a token, and there was none or a wrong one",
                    "say hello with the \"token\" that whoever runs the server gave you");
        }
        return token;
    }

    /** Only what is wrong counts: a right token opens the server from any address. */
    private void countWrong(Connection connection) throws Ending {
        if (!attempts.take(connection.address(), System.nanoTime())) {
            throw Ending.cut(
                    "too-many-attempts",
                    "too many wrong tokens came from your address; try again later");
        }
    }

    private static void requireOpen(
            ClientMessage.Hello hello, Role role, Optional<AgentToken> token, ServedWorld world)
            throws Ending {
        Rights rights = token.map(AgentToken::rights).orElse(Rights.ALL);
        if (token.isPresent() && !token.get().name().equals(hello.name())) {
            throw Ending.refused(
                    "not-permitted",
                    "your token is for another name than " + Text.quote(hello.name()),
                    "say hello with the name that it was made for");
        }
        if (!rights.roles().contains(role)) {
            throw Ending.refused(
                    "not-permitted",
                    "your token does not open the role " + role.wireName(),
                    "it opens " + rights.roles().stream().map(Role::wireName).sorted().toList());
        }
        if (hello.lockStep().isPresent() && !rights.lockStep()) {
            throw Ending.refused(
                    "not-permitted",
                    "your token does not let the world wait for you",
                    "leave out time, or ask for a token with lock-step");
        }
        if (!rights.opensWorld(world.name())) {
            throw Ending.refused(
                    "not-permitted",
                    "your token does not open the world " + world.name(),
                    "ask whoever runs the server for one that does");
        }
    }

    /** Keeps a session without a token for its client. @return false if there are too many */
    boolean keep(Session session) {
        int most = config.limits().kept();
        synchronized (kept) {
            if (kept.size() < most) {
                kept.add(session);
                return true;
            }
        }
        log.warn(
                () ->
                        session
                                + " leaves at once: "
                                + most
                                + " sessions without a token wait for their clients already");
        return false;
    }

    /** Its client is back, or its time is over. Does nothing if it was not kept. */
    void keepNoLonger(Session session) {
        synchronized (kept) {
            kept.remove(session);
        }
    }

    /** It has said hello. */
    void known(Connection connection) {
        strangers.remove(connection);
    }

    void forget(Connection connection) {
        strangers.remove(connection);
        if (connections.remove(connection)) {
            counters.open.decrement();
        }
    }

    private static Role requireAcceptable(ClientMessage.Hello hello) throws Ending {
        if (hello.protocol() != PROTOCOL) {
            throw Ending.refused(
                    "protocol-unsupported",
                    "this server does not speak protocol " + hello.protocol(),
                    "say hello with \"protocol\":" + PROTOCOL);
        }
        if (!isName(hello.name())) {
            throw Ending.refused(
                    "bad-name",
                    Text.quote(hello.name()) + " is no name for an agent",
                    "use 1 to 64 of A-Z a-z 0-9 _ . - and begin with a letter or digit");
        }
        return Role.of(hello.role())
                .orElseThrow(
                        () ->
                                Ending.refused(
                                        "role-unsupported",
                                        "this server does not know the role "
                                                + Text.quote(hello.role()),
                                        "it knows " + Role.names()));
    }

    /** Whether a client may be called that. */
    static boolean isName(String name) {
        return NAME.matcher(name).matches();
    }

    // ---- connections ----

    private static ServerSocketChannel listen(InetSocketAddress address) throws IOException {
        ServerSocketChannel listening = ServerSocketChannel.open();
        try {
            listening.setOption(StandardSocketOptions.SO_REUSEADDR, true);
            return listening.bind(address, BACKLOG);
        } catch (IOException e) {
            closeQuietly(listening);
            var unbound =
                    new BindException(
                            "cannot serve agents on "
                                    + address.getHostString()
                                    + " port "
                                    + address.getPort()
                                    + ": "
                                    + e.getMessage()
                                    + "; name another address or port (0: any free one)");
            unbound.initCause(e);
            throw unbound;
        }
    }

    private void accept() {
        try {
            for (int i = 0; i < ACCEPTED_PER_TURN; i++) {
                SocketChannel accepted = listening.accept();
                if (accepted == null) {
                    return;
                }
                admit(accepted);
            }
        } catch (IOException e) { // out of descriptors: wait for some to come free
            log.error("accepting a connection failed", e);
            accepting.interestOps(0);
        }
    }

    private void admit(SocketChannel channel) {
        counters.connections.increment();
        if (connections.size() >= config.limits().maxConnections()) {
            turnAway(channel, full());
            return;
        }
        try {
            var client = (InetSocketAddress) channel.getRemoteAddress();
            if (!strangers.haveRoomFor(client.getAddress())) {
                turnAway(
                        channel,
                        Ending.cut(
                                "too-many-connections",
                                "too many connections from your address have not said hello"));
                return;
            }
            var connection = new Connection(this, wire(channel));
            connections.add(connection);
            strangers.add(connection);
            counters.open.increment();
        } catch (IOException e) {
            closeQuietly(channel); // it has gone by itself
        }
    }

    private Wire wire(SocketChannel channel) {
        return config.security().tls().isEmpty()
                ? Wire.of(channel)
                : new TlsWire(channel, config.security().tls().get().engine());
    }

    private Ending full() {
        return Ending.cut(
                "too-many-connections",
                "the server has "
                        + config.limits().maxConnections()
                        + " clients, which is all it takes");
    }

    private void turnAway(SocketChannel channel, Ending why) {
        counters.cut.increment();
        try (channel) {
            SocketAddress client = channel.getRemoteAddress();
            strangersLog.warn(
                    () -> "a client at " + client + " was turned away: " + why.getMessage());
            channel.configureBlocking(false);
            if (config.security().tls().isEmpty()) { // else it would take a handshake
                channel.write(ByteBuffer.wrap(why.bye().in(Encoding.JSON)));
            }
            channel.shutdownOutput();
        } catch (IOException e) {
            // It has gone by itself.
        }
    }

    private static void closeQuietly(Closeable resource) {
        try {
            resource.close();
        } catch (IOException e) {
            // Closing frees the descriptor even when it complains.
        }
    }
}
