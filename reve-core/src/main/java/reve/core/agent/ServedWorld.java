// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import org.jspecify.annotations.Nullable;

import reve.core.agent.ServerMessage.Limits;
import reve.core.agent.ServerMessage.Welcome;
import reve.core.frame.FrameGate;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;

import java.time.Duration;
import java.util.ArrayDeque;
import java.util.Deque;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;

/** One of the worlds of a server: who is in it, and how they are told and obeyed. */
final class ServedWorld implements AutoCloseable {

    /** Agents named in one line of the log. */
    private static final int MOST_NAMED = 8;

    private final AgentServer server;
    private final WorldPort port;
    private final Publisher publisher;
    private final ControlDesk desk;
    private final LockStep lockStep;
    private final Subscription subscription;
    private final Map<String, Session> sessions = new ConcurrentHashMap<>();
    private final Deque<AgentCommand> leaving = new ArrayDeque<>();
    private volatile boolean ended;

    /**
     * @param waiting how its frame loop waits for agents in lock-step
     */
    ServedWorld(AgentServer server, WorldPort port, LockStep.Waiting waiting) {
        this.server = server;
        this.port = port;
        this.publisher = new Publisher(port, server.log(), this::queueLeaving, server::wake);
        this.desk = new ControlDesk(port, publisher, server.log());
        var allowances =
                new Allowances(
                        1_000_000_000L / port.framesPerSecond(),
                        server.config().timeouts().waiting(),
                        this::tellWaiting);
        this.lockStep = new LockStep(port.loop()::wake, desk::lockStep, allowances, waiting);
        port.loop().setGate(lockStep);
        this.subscription =
                port.bus().subscribe(FramePhase.PUBLISH, "agent server", publisher::onFrame);
    }

    String name() {
        return port.world();
    }

    int framesPerSecond() {
        return port.framesPerSecond();
    }

    AgentServer server() {
        return server;
    }

    Publisher publisher() {
        return publisher;
    }

    ControlDesk desk() {
        return desk;
    }

    LockStep lockStep() {
        return lockStep;
    }

    Cameras cameras() {
        return port.cameras();
    }

    /** True if nobody can come in any more. */
    boolean hasEnded() {
        return ended;
    }

    /** No more frames are made: says bye to everybody who is there. */
    void end() {
        ended = true;
        sessions.values()
                .forEach(
                        session ->
                                session.end(
                                        Ending.regular(
                                                "closing",
                                                "the world " + Text.quote(name()) + " ends")));
    }

    /** Hears of no more frames. */
    @Override
    public void close() {
        port.loop().setGate(FrameGate.OPEN);
        subscription.close();
    }

    void checkGrace(long nowNanos) {
        sessions.values().forEach(session -> session.checkGrace(nowNanos));
    }

    /**
     * @param current the tokens that open the server now
     */
    void checkTokens(Set<AgentToken> current) {
        sessions.values().forEach(session -> session.checkToken(current));
    }

    /** How many there are, with those whose connection broke and may come back. */
    int clients() {
        return sessions.size();
    }

    /** An allowance is spent, or counts again. Loop's thread; once in a while. */
    private void tellWaiting(Allowance allowance) {
        boolean spent = allowance.isSpent();
        publisher.later(
                () -> {
                    List<String> names =
                            sessions.values().stream()
                                    .filter(session -> session.has(allowance))
                                    .map(Session::name)
                                    .sorted()
                                    .toList();
                    sessions.values().forEach(session -> session.tellWaiting(allowance));
                    String agents =
                            String.join(", ", names.subList(0, Math.min(names.size(), MOST_NAMED)))
                                    + (names.size() > MOST_NAMED ? " and others" : "");
                    if (spent) {
                        server.log()
                                .warn(
                                        "world "
                                                + Text.quote(name())
                                                + " no longer waits for agents in lock-step longer"
                                                + " than a frame: others waited too long for "
                                                + agents
                                                + "; serve --waiting allows more");
                    } else {
                        server.log()
                                .info(
                                        "world "
                                                + Text.quote(name())
                                                + " waits for "
                                                + agents
                                                + " again, until their deadlines");
                    }
                });
    }

    /** Tells an agent in lock-step whose allowance is spent how long the world waits for it. */
    Optional<ServerMessage.Event> hurry(@Nullable Turn turn, long frame) {
        return Optional.ofNullable(turn)
                .filter(its -> its.allowance().isSpent())
                .map(its -> waiting(its, frame));
    }

    ServerMessage.Event waiting(Turn turn, long frame) {
        return new ServerMessage.Event(
                frame,
                "waiting",
                Map.of("longest", lockStep.allowances().longestWaitNanos(turn) / 1e9));
    }

    // ---- coming and going ----

    /**
     * Lets a client in.
     *
     * @param token that opened the server for it, if the server takes tokens
     * @return its session; the welcome comes when the world has taken it
     * @throws Ending if it cannot come in
     */
    Session greet(
            Connection connection, Role role, ClientMessage.Hello hello, Optional<AgentToken> token)
            throws Ending {
        var session = new Session(this, connection, role, hello, token);
        if (sessions.putIfAbsent(hello.name(), session) != null) {
            throw Ending.nameTaken(hello.name());
        }
        if (role != Role.AGENT) {
            publisher.later(() -> session.welcome(Optional.empty(), publisher.published()));
            return session;
        }
        Rights rights = token.map(AgentToken::rights).orElse(Rights.ALL);
        var join =
                desk.command(
                        new AgentInput.Join(hello.name(), hello.body(), rights), session::came);
        if (!port.commands().offer(join)) {
            sessions.remove(hello.name());
            throw Ending.refused(
                    "world-busy", "the world has more to do than fits into a frame", "try again");
        }
        lockStep.comes();
        return session;
    }

    /** Who is there by that name, or was a moment ago. */
    Optional<Session> find(String client) {
        return Optional.ofNullable(sessions.get(client));
    }

    Welcome welcome(Session session, ClientMessage.Hello hello, long frame, boolean resumed) {
        AgentLimits limits = server.config().limits();
        AgentTimeouts timeouts = server.config().timeouts();
        var told =
                new Limits(
                        limits.lineBytes(),
                        limits.messagesPerSecond(),
                        limits.actsInFlight(),
                        seconds(timeouts.idle()),
                        seconds(timeouts.grace()),
                        port.agents().items(),
                        port.agents().worldItems(),
                        port.agents().eventBytes(),
                        port.agents().worldEventBytes());
        return new Welcome(
                hello.id(),
                AgentServer.PROTOCOL,
                session.role(),
                hello.name(),
                session.body(),
                port.world(),
                frame,
                port.framesPerSecond(),
                session.encoding(),
                session.rhythm(),
                Optional.ofNullable(session.ticket()),
                resumed,
                told);
    }

    private static double seconds(Duration duration) {
        return duration.toMillis() / 1000.0;
    }

    /** Takes a client out of the world, in the next frame that has room for the command. */
    synchronized void leave(Session session, String reason) {
        if (session.role() == Role.AGENT) {
            leaving.add(desk.command(new AgentInput.Leave(session.name(), reason), outcome -> {}));
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
}
