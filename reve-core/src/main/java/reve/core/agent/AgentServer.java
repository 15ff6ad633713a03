package reve.core.agent;

import java.io.Closeable;
import java.io.IOException;
import java.io.OutputStream;
import java.net.BindException;
import java.net.InetSocketAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.time.Clock;
import java.time.Duration;
import java.util.ArrayDeque;
import java.util.Deque;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.regex.Pattern;
import reve.core.agent.ServerMessage.Limits;
import reve.core.agent.ServerMessage.Welcome;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;

/**
 * Lets agents join a world over TCP, protocol version 1. The world goes on at its own pace whatever agents do; they
 * come and go at any time. Its methods may be called from any thread.
 */
public final class AgentServer implements AutoCloseable {

    /** The protocol version it speaks. */
    public static final int PROTOCOL = 1;

    private static final Pattern NAME = Pattern.compile("[A-Za-z0-9][A-Za-z0-9_.-]{0,63}");
    private static final int BACKLOG = 512;
    private static final int CHECKS_PER_DEADLINE = 4;
    private static final long ACCEPT_RETRY_MILLIS = 100;

    private final WorldPort port;
    private final AgentServerConfig config;
    private final Counters counters = new Counters();
    private final RateLimitedLog log = new RateLimitedLog();
    private final Publisher publisher;
    private final ControlDesk desk;
    private final ServerSocket socket;
    private final Set<Connection> connections = ConcurrentHashMap.newKeySet();
    private final Map<String, Session> sessions = new ConcurrentHashMap<>();
    private final Deque<AgentCommand> leaving = new ArrayDeque<>();
    private final Optional<AuditLog> audit;
    private final Subscription subscription;
    private final Thread acceptor;
    private final Thread watch;
    private volatile boolean closed;

    /**
     * Begins to listen.
     *
     * @throws BindException naming the address if it cannot be had
     * @throws IOException if the audit file cannot be written
     */
    public static AgentServer start(AgentServerConfig config, WorldPort port) throws IOException {
        ServerSocket socket = listen(config.address());
        AgentServer server;
        try {
            server = new AgentServer(config, port, socket, openAudit(config));
        } catch (IOException e) {
            closeQuietly(socket);
            throw e;
        }
        server.publisher.start();
        server.watch.start();
        server.acceptor.start();
        return server;
    }

    private static Optional<AuditLog> openAudit(AgentServerConfig config) throws IOException {
        return config.audit().isPresent()
                ? Optional.of(new AuditLog(config.audit().get(), Clock.systemUTC())) : Optional.empty();
    }

    private AgentServer(AgentServerConfig config, WorldPort port, ServerSocket socket, Optional<AuditLog> audit) {
        this.audit = audit;
        this.config = config;
        this.port = port;
        this.socket = socket;
        this.publisher = new Publisher(port, log, this::queueLeaving);
        this.desk = new ControlDesk(port, publisher, log);
        this.subscription = port.bus().subscribe(FramePhase.PUBLISH, "agent server", publisher::onFrame);
        this.acceptor = Thread.ofVirtual().name("agent acceptor").unstarted(this::accept);
        this.watch = Thread.ofVirtual().name("agent deadlines").unstarted(this::watch);
    }

    /** Where it listens, with the port it got. */
    public InetSocketAddress address() {
        return (InetSocketAddress) socket.getLocalSocketAddress();
    }

    public AgentStats stats() {
        return counters.read();
    }

    /** Says bye to everybody and returns when all are gone, at the latest after the time to linger. */
    @Override
    public void close() {
        if (closed) {
            return;
        }
        closed = true;
        subscription.close();
        closeQuietly(socket);
        connections.forEach(connection -> connection.end(Ending.regular("closing", "the server ends")));
        try {
            for (Connection connection : connections) {
                if (!connection.join(config.linger())) {
                    connection.closeSocket();
                }
            }
            acceptor.join();
        } catch (InterruptedException e) {
            connections.forEach(Connection::closeSocket);
            Thread.currentThread().interrupt();
        }
        watch.interrupt();
        publisher.stop();
        audit.ifPresent(AgentServer::closeQuietly);
    }

    // ---- for connections and sessions ----

    AgentServerConfig config() {
        return config;
    }

    Counters counters() {
        return counters;
    }

    RateLimitedLog log() {
        return log;
    }

    ControlDesk desk() {
        return desk;
    }

    Optional<AuditLog> audit() {
        return audit;
    }

    long published() {
        return publisher.published();
    }

    void admit(Session session) {
        publisher.admit(session);
    }

    Welcome welcome(Session session, ClientMessage.Hello hello, long frame, boolean resumed) {
        return new Welcome(hello.id(), PROTOCOL, session.role(), hello.name(), session.body(), port.world(), frame,
                port.framesPerSecond(), session.encoding(), Optional.ofNullable(session.ticket()), resumed,
                new Limits(config.lineBytes(), config.actsInFlight(), seconds(config.idle()), seconds(config.grace())));
    }

    private static double seconds(Duration duration) {
        return duration.toMillis() / 1000.0;
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
        var session = new Session(this, connection, role, hello);
        if (sessions.putIfAbsent(hello.name(), session) != null) {
            throw Ending.refused("name-taken", "another client is called " + Text.quote(hello.name()),
                    "say hello with another name");
        }
        if (role != Role.AGENT) {
            publisher.later(() -> session.welcome(Optional.empty(), published()));
            return session;
        }
        var join = desk.command(new AgentInput.Join(hello.name(), hello.body()), session::joined);
        if (!port.commands().offer(join)) {
            sessions.remove(hello.name());
            throw Ending.refused("world-busy", "the world has more to do than fits into a frame", "try again");
        }
        return session;
    }

    private Session resume(Connection connection, ClientMessage.Hello hello, ClientMessage.Resume resume)
            throws Ending {
        Session session = sessions.get(hello.name());
        if (session == null || !session.hasToken(resume.session())) {
            throw Ending.refused("no-such-session", "there is no session of " + Text.quote(hello.name())
                    + " with this token, or it has ended", "say hello without resume");
        }
        session.resume(connection, resume.frame());
        return session;
    }

    /** Takes a client out of the world, in the next frame that has room for the command. */
    synchronized void leave(Session session, String reason) {
        if (session.role() == Role.AGENT) {
            leaving.add(desk.command(new AgentInput.Leave(session.name(), reason), outcome -> { }));
            queueLeaving();
        } else {
            sessions.remove(session.name());
        }
    }

    /** Once queued, the name is free again: commands of one name keep their order. */
    private synchronized void queueLeaving() {
        while (!leaving.isEmpty() && port.commands().offer(leaving.getFirst())) {
            sessions.remove(leaving.removeFirst().origin());
        }
    }

    void forget(Connection connection) {
        if (connections.remove(connection)) {
            counters.open.decrement();
        }
    }

    private static Role requireAcceptable(ClientMessage.Hello hello) throws Ending {
        if (hello.protocol() != PROTOCOL) {
            throw Ending.refused("protocol-unsupported", "this server does not speak protocol " + hello.protocol(),
                    "say hello with \"protocol\":" + PROTOCOL);
        }
        if (!NAME.matcher(hello.name()).matches()) {
            throw Ending.refused("bad-name", Text.quote(hello.name()) + " is no name for an agent",
                    "use 1 to 64 of A-Z a-z 0-9 _ . - and begin with a letter or digit");
        }
        return Role.of(hello.role()).orElseThrow(() -> Ending.refused("role-unsupported",
                "this server does not know the role " + Text.quote(hello.role()), "it knows " + Role.names()));
    }

    // ---- connections ----

    private static ServerSocket listen(InetSocketAddress address) throws IOException {
        var socket = new ServerSocket();
        try {
            socket.setReuseAddress(true);
            socket.bind(address, BACKLOG);
            return socket;
        } catch (IOException e) {
            closeQuietly(socket);
            var unbound = new BindException("cannot serve agents on " + address.getHostString() + " port "
                    + address.getPort() + ": " + e.getMessage());
            unbound.initCause(e);
            throw unbound;
        }
    }

    private void accept() {
        while (!closed) {
            try {
                admit(socket.accept());
            } catch (IOException e) {
                pauseAfter(e);
            }
        }
    }

    private void admit(Socket connection) {
        counters.connections.increment();
        if (counters.open.sum() >= config.maxConnections()) {
            turnAway(connection);
            return;
        }
        var accepted = new Connection(this, connection);
        connections.add(accepted);
        counters.open.increment();
        accepted.start();
        if (closed) { // close() may have looked before we added it
            accepted.end(Ending.regular("closing", "the server ends"));
        }
    }

    private void turnAway(Socket connection) {
        Ending why = Ending.cut("too-many-connections",
                "the server has " + config.maxConnections() + " connections, which is all it takes");
        counters.cut.increment();
        try (connection; OutputStream out = connection.getOutputStream()) {
            out.write(why.bye().in(Encoding.JSON));
            connection.shutdownOutput();
        } catch (IOException e) {
            // It has gone by itself.
        }
        log.warn("a client at " + connection.getRemoteSocketAddress() + " was turned away: " + why.getMessage());
    }

    /** Accepting fails when the process is out of descriptors: wait for some to come free. */
    private void pauseAfter(IOException failure) {
        if (!closed) {
            log.error("accepting a connection failed", failure);
            pause(ACCEPT_RETRY_MILLIS);
        }
    }

    private void watch() {
        long shortest = Math.min(config.write().toMillis(), config.linger().toMillis());
        while (!Thread.currentThread().isInterrupted()) {
            pause(Math.max(1, shortest / CHECKS_PER_DEADLINE));
            long now = System.nanoTime();
            connections.forEach(connection -> connection.checkDeadlines(now));
            sessions.values().forEach(session -> session.checkGrace(now));
        }
    }

    private static void pause(long millis) {
        try {
            Thread.sleep(millis);
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
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
