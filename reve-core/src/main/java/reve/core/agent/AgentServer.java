package reve.core.agent;

import java.io.IOException;
import java.io.OutputStream;
import java.net.BindException;
import java.net.InetSocketAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.util.ArrayDeque;
import java.util.Deque;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.atomic.AtomicLong;
import java.util.function.Consumer;
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
    private final Members members;
    private final ServerSocket socket;
    private final Set<Session> sessions = ConcurrentHashMap.newKeySet();
    private final Set<String> names = ConcurrentHashMap.newKeySet();
    private final Deque<AgentCommand> leaving = new ArrayDeque<>();
    private final AtomicLong sequence = new AtomicLong();
    private final Subscription subscription;
    private final Thread acceptor;
    private final Thread watch;
    private volatile boolean closed;

    /**
     * Begins to listen.
     *
     * @throws BindException naming the address if it cannot be had
     */
    public static AgentServer start(AgentServerConfig config, WorldPort port) throws IOException {
        var server = new AgentServer(config, port, listen(config.address()));
        server.publisher.start();
        server.watch.start();
        server.acceptor.start();
        return server;
    }

    private AgentServer(AgentServerConfig config, WorldPort port, ServerSocket socket) {
        this.config = config;
        this.port = port;
        this.socket = socket;
        this.publisher = new Publisher(port, log, this::queueLeaving);
        this.members = new Members(port.agents());
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
        sessions.forEach(session -> session.end(Ending.regular("closing", "the server ends")));
        try {
            for (Session session : sessions) {
                if (!session.join(config.linger())) {
                    session.closeSocket();
                }
            }
            acceptor.join();
        } catch (InterruptedException e) {
            sessions.forEach(Session::closeSocket);
            Thread.currentThread().interrupt();
        }
        watch.interrupt();
        publisher.stop();
    }

    // ---- for sessions ----

    AgentServerConfig config() {
        return config;
    }

    Counters counters() {
        return counters;
    }

    RateLimitedLog log() {
        return log;
    }

    long published() {
        return publisher.published();
    }

    void admit(Session session) {
        publisher.admit(session);
    }

    Welcome welcome(ClientMessage.Hello hello, String body, long frame) {
        return new Welcome(hello.id(), PROTOCOL, hello.name(), body, port.world(), frame, port.framesPerSecond(),
                new Limits(config.lineBytes(), config.actsInFlight(), config.idle().toMillis() / 1000.0));
    }

    /**
     * Asks the world to let an agent in, under a name that it holds until it leaves.
     *
     * @throws Ending if it cannot come in
     */
    void join(Session session, ClientMessage.Hello hello) throws Ending {
        requireAcceptable(hello);
        if (!names.add(hello.name())) {
            throw Ending.refused("name-taken", "another agent is called " + Text.quote(hello.name()),
                    "say hello with another name");
        }
        if (!port.commands().offer(command(new AgentInput.Join(hello.name(), hello.body()), session::joined))) {
            names.remove(hello.name());
            throw Ending.refused("world-busy", "the world has more to do than fits into a frame", "try again");
        }
    }

    /** Hands an act to the world. @return false if the world has no room for it */
    boolean act(AgentInput.Act act, Consumer<Outcome> answer) {
        return port.commands().offer(command(act, answer));
    }

    /** Takes an agent out of the world, in the next frame that has room for the command. */
    synchronized void leave(String agent, String reason) {
        leaving.add(command(new AgentInput.Leave(agent, reason), outcome -> { }));
        queueLeaving();
    }

    private AgentCommand command(AgentInput input, Consumer<Outcome> answer) {
        return new AgentCommand(publisher, members, sequence.incrementAndGet(), input, answer);
    }

    /** Once queued, the name is free again: commands of one name keep their order. */
    private synchronized void queueLeaving() {
        while (!leaving.isEmpty() && port.commands().offer(leaving.getFirst())) {
            names.remove(leaving.removeFirst().origin());
        }
    }

    void forget(Session session) {
        if (sessions.remove(session)) {
            counters.open.decrement();
        }
    }

    private static void requireAcceptable(ClientMessage.Hello hello) throws Ending {
        if (hello.protocol() != PROTOCOL) {
            throw Ending.refused("protocol-unsupported", "this server does not speak protocol " + hello.protocol(),
                    "say hello with \"protocol\":" + PROTOCOL);
        }
        if (!hello.role().equals("agent")) {
            throw Ending.refused("role-unsupported", "this server does not know the role " + Text.quote(hello.role()),
                    "say hello with \"role\":\"agent\", or leave it out");
        }
        if (!NAME.matcher(hello.name()).matches()) {
            throw Ending.refused("bad-name", Text.quote(hello.name()) + " is no name for an agent",
                    "use 1 to 64 of A-Z a-z 0-9 _ . - and begin with a letter or digit");
        }
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
        var session = new Session(this, connection);
        sessions.add(session);
        counters.open.increment();
        session.start();
        if (closed) { // close() may have looked before we added it
            session.end(Ending.regular("closing", "the server ends"));
        }
    }

    private void turnAway(Socket connection) {
        Ending why = Ending.cut("too-many-connections",
                "the server has " + config.maxConnections() + " connections, which is all it takes");
        counters.cut.increment();
        try (connection; OutputStream out = connection.getOutputStream()) {
            out.write(why.bye().line());
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
            sessions.forEach(session -> session.checkDeadlines(now));
        }
    }

    private static void pause(long millis) {
        try {
            Thread.sleep(millis);
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        }
    }

    private static void closeQuietly(ServerSocket socket) {
        try {
            socket.close();
        } catch (IOException e) {
            // Closing frees the descriptor even when it complains.
        }
    }
}
