// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.auth.AgentSecurity;
import reve.core.agent.auth.ServerTls;
import reve.core.agent.auth.TokenFile;
import reve.core.agent.embodiment.Rewound;
import reve.core.agent.lockstep.LockStep;
import reve.core.agent.net.Connections;
import reve.core.agent.net.Counters;
import reve.core.agent.net.Descriptors;
import reve.core.agent.net.EventLoop;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.Elsewhere;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Relay;
import reve.core.agent.publish.Publisher;
import reve.core.agent.session.Admission;
import reve.core.agent.session.KeptSessions;
import reve.core.agent.session.ServedWorld;
import reve.core.agent.session.SessionServices;
import reve.core.frame.Pacing;

import java.io.Closeable;
import java.io.IOException;
import java.net.BindException;
import java.net.InetSocketAddress;
import java.net.StandardSocketOptions;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.atomic.AtomicReference;
import java.util.stream.Stream;

/**
 * Server for agents (client programs) over TCP, protocol version 1. It serves one or more worlds.
 * The frames of one world do not wait for those of another. Agents join and leave at any time.
 * Methods may be called on any thread.
 */
public final class AgentServer implements AutoCloseable {

    private static final int BACKLOG = 512;
    private static final int CHECKS_PER_DEADLINE = 4;

    /** Interval between two checks whether the event loop still runs [ms]. */
    private static final long CHECK_MILLIS = 100;

    private final AgentServerConfig config;
    private volatile Elsewhere elsewhere = Elsewhere.NOWHERE;
    private final Counters counters = new Counters();
    private final RateLimitedLog log = new RateLimitedLog(10, "agents");

    private final SessionServices services;
    private final List<ServedWorld> worlds = new CopyOnWriteArrayList<>();
    private final EventLoop loop;
    private final InetSocketAddress address;
    private final Admission admission;
    private final Connections connections;
    private final Descriptors descriptors;
    private final Optional<AuditLog> audit;

    /** Only the event loop's thread uses this list while the loop runs. */
    private final List<FileProblem> fileProblems;

    private volatile boolean closed;

    /**
     * Starts the server.
     *
     * @param ports the worlds to serve; their names must differ. {@link #add} adds more
     * @param problems receives problems with the server's files (audit record, tokens, certificate)
     *     while it runs
     * @throws BindException naming the address if it is not available
     * @throws IOException if the audit record cannot be written, or the limit of open files is too
     *     low
     */
    public static AgentServer start(
            AgentServerConfig config, List<WorldPort> ports, ServerProblems problems)
            throws IOException {
        return start(config, ports, Map.of(), problems);
    }

    /**
     * Starts the server, and continues sessions that another server has ended. The sessions wait
     * for their clients as after a broken connection. For the thread that owns the worlds, before
     * their first frames.
     *
     * @param ports the worlds to serve, as in {@link #start(AgentServerConfig, List,
     *     ServerProblems)}
     * @param carried the sessions, by the names of their worlds; the worlds have their bodies
     * @param problems as in {@link #start(AgentServerConfig, List, ServerProblems)}
     * @throws IOException like {@link #start(AgentServerConfig, List, ServerProblems)}
     */
    public static AgentServer start(
            AgentServerConfig config,
            List<WorldPort> ports,
            Map<String, List<CarriedSession>> carried,
            ServerProblems problems)
            throws IOException {
        ServerSocketChannel listening = listen(config.address());
        try {
            Descriptors descriptors = Descriptors.ofProcess();
            var server =
                    new AgentServer(
                            config, ports, listening, openAudit(config), descriptors, problems);
            // A client may ask for its session as soon as the loop runs.
            carried.forEach(server::restore);
            server.loop.start();
            server.connections.start();
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
            Descriptors descriptors,
            ServerProblems problems)
            throws IOException {
        this.audit = audit;
        this.descriptors = descriptors;
        this.config = config;
        this.fileProblems = fileProblems(config.security(), audit, problems);
        this.address =
                new InetSocketAddress(
                        config.address().getAddress(),
                        ((InetSocketAddress) listening.getLocalAddress()).getPort());
        this.loop =
                new EventLoop(
                        log, new LoopWork(), shortest(config.timeouts()) / CHECKS_PER_DEADLINE);
        this.services =
                new SessionServices(
                        config.limits(),
                        config.timeouts(),
                        counters,
                        log,
                        new KeptSessions(config.limits().kept(), log),
                        loop::wake,
                        audit,
                        () -> elsewhere.servers(),
                        () -> worlds.size() > 1);
        // The world's thread may run the event loop while it waits for agents. It does so only if
        // this is the only world and the world has no fixed frame rate. Otherwise, serving agents
        // on this thread could delay the next frame.
        boolean helps = ports.size() == 1 && ports.getFirst().loop().pacing() == Pacing.FAST;
        LockStep.Waiting waiting = helps ? new LoopHelper(loop) : LockStep.Waiting.IDLE;
        ports.forEach(port -> worlds.add(new ServedWorld(services, port, waiting)));
        this.admission =
                new Admission(
                        worlds,
                        config.limits().maxConnections(),
                        config.security().tokens(),
                        audit);
        this.connections =
                new Connections(
                        config.limits(),
                        config.timeouts(),
                        config.security().tls().map(tls -> tls::engine),
                        counters,
                        log,
                        audit,
                        admission,
                        loop,
                        descriptors,
                        listening);
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

    /** Returns the address of the server, with the actual port. */
    public InetSocketAddress address() {
        return address;
    }

    /**
     * Opens a connection for a client that another server of this process has accepted. An example
     * is a web page, which the web server has accepted. The same rights, limits and audit record
     * apply as to any other connection.
     *
     * @param client address of the client; limits per address count this address
     * @param relay is notified when the session begins and when the connection ends
     * @return the client's end of the connection, in blocking mode: lines of JSON, without TLS. The
     *     caller closes it.
     * @throws IOException if the process may open no more files; the log reports it
     */
    public SocketChannel connect(InetSocketAddress client, Relay relay) throws IOException {
        if (!descriptors.takeIfLeft(SocketPair.DESCRIPTORS)) {
            throw connections.noDescriptors();
        }
        SocketPair pair = SocketPair.open();
        loop.later(() -> connections.admit(pair.inner(), client, relay));
        return pair.outer();
    }

    /**
     * Returns the number of connections that another server of this process may have open. The
     * number is limited, because each such connection takes up to three file descriptors. A quarter
     * of all descriptors stays free for this server's own connections.
     */
    public int roomForOtherServers() {
        return Math.clamp(descriptors.room() / 4, 1, config.limits().maxConnections());
    }

    /**
     * Takes a file descriptor for a connection of another server of this process.
     *
     * @return false, without effect, if the remaining descriptors are reserved for store files and
     *     records
     */
    public boolean takeDescriptor() {
        return descriptors.takeIfLeft(1);
    }

    /**
     * Writes a message to the audit record, if the server keeps one. Another server of this process
     * calls this method if it sends the content to its client in another form, for example as
     * binary data to a web page. For any thread.
     *
     * @param message a JSON object
     * @return false if the message could not be recorded and must therefore not be sent
     */
    public boolean record(String world, String client, String message) {
        return audit.isEmpty()
                || audit.get()
                        .told(
                                world,
                                client,
                                Encoding.JSON,
                                StandardCharsets.UTF_8.encode(message + "\n"));
    }

    /** Returns the present counters. */
    public AgentStats stats() {
        return new AgentStats(
                counters.connections.sum(),
                counters.open.sum(),
                counters.agents.sum(),
                counters.joined.sum(),
                counters.lines.sum(),
                counters.errors.sum(),
                counters.perceptions.sum(),
                counters.actsAccepted.sum(),
                counters.actsRefused.sum(),
                counters.cut.sum(),
                audit.map(AuditLog::unrecorded).orElse(0L));
    }

    /**
     * Delays the first frame of a world until this number of agents waits to join. All these agents
     * then join in the same frame. Call this method before the world's loop runs.
     */
    public void expect(String world, int agents) {
        served(world).expectAgents(agents);
    }

    /**
     * Sets the source of the worlds that other servers have. A client that asks for such a world is
     * referred to its server. For any thread.
     */
    public void sendTo(Elsewhere others) {
        elsewhere = others;
        admission.sendTo(others);
    }

    /** Returns the number of agents of a world that are in lock-step. */
    public int inLockStep(String world) {
        return served(world).inLockStep();
    }

    private ServedWorld served(String world) {
        return worlds.stream()
                .filter(served -> served.name().equals(world))
                .findFirst()
                .orElseThrow(
                        () ->
                                new IllegalArgumentException(
                                        "world is "
                                                + world
                                                + ", expected one of "
                                                + worlds.stream().map(ServedWorld::name).toList()));
    }

    /**
     * Serves another world. Call this method before the world's loop runs. For any thread.
     *
     * @throws IllegalArgumentException if the server has a world of this name
     */
    public void add(WorldPort port) {
        add(port, List.of());
    }

    /**
     * Serves another world, and continues sessions that another server has ended. The sessions wait
     * for their clients as after a broken connection. For the world's thread.
     *
     * @param carried the sessions; the world has their bodies
     * @throws IllegalArgumentException if the server has a world of this name
     */
    public void add(WorldPort port, List<CarriedSession> carried) {
        synchronized (worlds) {
            if (worlds.stream().anyMatch(world -> world.name().equals(port.world()))) {
                throw new IllegalArgumentException(
                        "the server has a world " + port.world() + " already");
            }
            var served = new ServedWorld(services, port, LockStep.Waiting.IDLE);
            served.restore(carried, config.security().tokens().map(TokenFile::current));
            worlds.add(served);
        }
    }

    private void restore(String world, List<CarriedSession> carried) {
        served(world).restore(carried, config.security().tokens().map(TokenFile::current));
    }

    /** Removes a world that ends, like {@link #remove(String, Optional)}. */
    public void remove(String world) {
        remove(world, Optional.empty());
    }

    /**
     * Removes a world that makes no more frames: sends {@code bye} to all its clients, and ends
     * their sessions. The server does not use the world after this method has returned. For the
     * world's thread.
     *
     * @param next HOST:PORT of the server that the clients shall ask for the world; empty if the
     *     world ends
     * @return the sessions that the next server can continue, in the order of their names
     */
    public List<CarriedSession> remove(String world, Optional<String> next) {
        ServedWorld served = served(world);
        var carried = new AtomicReference<List<CarriedSession>>(List.of());
        onLoop(
                () -> {
                    try {
                        carried.set(served.dismiss(next));
                    } finally {
                        worlds.remove(served);
                    }
                });
        served.close();
        return carried.get();
    }

    /**
     * Restarts the streams of perceptions of a world's clients, because the world was rewound
     * elsewhere and this server shows a copy of it. For any thread.
     *
     * @param frame the frame that shows the rewound world
     */
    public void rewound(String world, long frame) {
        Publisher publisher = served(world).publisher();
        publisher.later(() -> publisher.tellRewound(new Rewound(frame, Map.of())));
    }

    /**
     * Ends a world like {@link #end} if it has no clients, and had none for a time. A client whose
     * session waits for another connection counts. Waits for the event loop's thread.
     *
     * @return whether this call has ended the world; false if the server has no such world
     */
    public boolean endIfUnused(String world, Duration time) {
        Optional<ServedWorld> found =
                worlds.stream()
                        .filter(served -> served.name().equals(world))
                        .filter(served -> served.isUnused(time))
                        .findFirst();
        var isEnded = new AtomicBoolean();
        found.ifPresent(served -> onLoop(() -> isEnded.set(served.endIfUnused(time))));
        return isEnded.get();
    }

    /**
     * Runs a task on the event loop's thread, and waits until the task or the loop has ended. An
     * interrupt does not end the wait.
     */
    private void onLoop(Runnable task) {
        var done = new CountDownLatch(1);
        loop.later(
                () -> {
                    try {
                        task.run();
                    } finally {
                        done.countDown();
                    }
                });
        boolean interrupted = false;
        while (done.getCount() > 0 && loop.isRunning()) {
            try {
                done.await(CHECK_MILLIS, TimeUnit.MILLISECONDS);
            } catch (InterruptedException e) {
                interrupted = true; // a world must not be freed while the loop may read it
            }
        }
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }

    /**
     * Ends a world: sends the message {@code bye} to all its clients, and admits no more clients to
     * it.
     */
    public void end(String world) {
        loop.later(
                () ->
                        worlds.stream()
                                .filter(served -> served.name().equals(world))
                                .forEach(ServedWorld::end));
    }

    /**
     * Sends {@code bye} to all clients. Returns when all connections are closed, or after the time
     * {@code linger} of the settings.
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
                    connections.close(CloseReason.regular("closing", "the server ends"));
                });
        try {
            if (!loop.join(2 * config.timeouts().linger().toMillis())) {
                loop.stop();
            }
        } catch (InterruptedException e) {
            loop.stop();
            Thread.currentThread().interrupt();
        }
        connections.stop();
        fileProblems.forEach(FileProblem::check);
        audit.ifPresent(AgentServer::closeQuietly);
    }

    /** The work that the event loop does in each turn after it has read from sockets. */
    private final class LoopWork implements EventLoop.Work {

        @Override
        public boolean isWaiting() {
            return connections.isWaiting() || hasNews();
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
                    connections.readThrottled();
                }
            }
            connections.writeAll();
            if (closed && connections.isEmpty()) {
                loop.stop();
            }
        }

        @Override
        public void checkDeadlines(long nowNanos) {
            connections.checkDeadlines(nowNanos);
            worlds.forEach(world -> world.checkGrace(nowNanos));
            connections.readThrottled();
            config.security().tls().ifPresent(ServerTls::refresh);
            fileProblems.forEach(FileProblem::check);
            config.security()
                    .tokens()
                    .map(TokenFile::current)
                    .ifPresent(current -> worlds.forEach(world -> world.checkTokens(current)));
            connections.acceptAgain();
        }
    }

    /** Returns the connections. For tests. */
    Connections connections() {
        return connections;
    }

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

    private static void closeQuietly(Closeable resource) {
        try {
            resource.close();
        } catch (IOException e) {
            // The exception is ignored, because the operating system frees the file descriptor even
            // if close() fails.
        }
    }
}
