// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.control.ControlDesk;
import reve.core.agent.embodiment.AgentCommand;
import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.lockstep.Allowance;
import reve.core.agent.lockstep.Allowances;
import reve.core.agent.lockstep.LockStep;
import reve.core.agent.lockstep.Turn;
import reve.core.agent.net.Connection;
import reve.core.agent.port.Cameras;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.ServerMessage.Limits;
import reve.core.agent.protocol.ServerMessage.Welcome;
import reve.core.agent.protocol.Text;
import reve.core.agent.publish.Publisher;
import reve.core.frame.FrameGate;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;

import java.time.Duration;
import java.util.ArrayDeque;
import java.util.Comparator;
import java.util.Deque;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;

/** One hosted world: its sessions, its publisher and its command queue. */
public final class ServedWorld implements AutoCloseable {

    /** Maximum number of agents in one line of the log. */
    private static final int MOST_NAMED = 8;

    private final SessionServices services;
    private final WorldPort port;
    private final Publisher publisher;
    private final ControlDesk desk;
    private final LockStep lockStep;
    private final Subscription subscription;
    private final Map<String, Session> sessions = new ConcurrentHashMap<>();
    private final Deque<AgentCommand> leaving = new ArrayDeque<>();
    private volatile boolean ended;

    /**
     * @param waiting the way in which the world's thread waits for agents in lock-step
     */
    public ServedWorld(SessionServices services, WorldPort port, LockStep.Waiting waiting) {
        this.services = services;
        this.port = port;
        this.publisher = new Publisher(port, services.log(), this::afterFrame, services.wake());
        this.desk = new ControlDesk(port, publisher, services.log(), this::describeClients);
        var allowances =
                new Allowances(
                        1_000_000_000L / port.framesPerSecond(),
                        services.timeouts().waiting(),
                        this::tellWaiting);
        this.lockStep = new LockStep(port.loop()::wake, desk::lockStep, allowances, waiting);
        port.loop().setGate(lockStep);
        this.subscription =
                port.bus()
                        .subscribe(
                                FramePhase.PUBLISH,
                                "agent server",
                                event -> publisher.onFrame(event, desk.takeHeard()));
    }

    /** Returns the name of the world. */
    public String name() {
        return port.world();
    }

    int framesPerSecond() {
        return port.framesPerSecond();
    }

    SessionServices services() {
        return services;
    }

    /** Returns the publisher, which sends the frames of the world to its clients. */
    public Publisher publisher() {
        return publisher;
    }

    ControlDesk desk() {
        return desk;
    }

    LockStep lockStep() {
        return lockStep;
    }

    /**
     * Holds the first frame until this number of agents waits to join. Call this method before the
     * loop runs.
     */
    public void expectAgents(int agents) {
        lockStep.expect(agents);
    }

    /** Returns the number of agents in lock-step. For any thread. */
    public int inLockStep() {
        return lockStep.size();
    }

    Cameras cameras() {
        return port.cameras();
    }

    /** Returns whether the world admits no more clients. */
    public boolean hasEnded() {
        return ended;
    }

    /** Ends the world: sends {@code bye} to all its clients. */
    public void end() {
        ended = true;
        sessions.values().forEach(session -> session.end(ends()));
    }

    /**
     * Ends the world and all sessions, also those whose clients may reconnect. For the event loop's
     * thread.
     */
    public void dismiss() {
        ended = true;
        sessions.values().forEach(session -> session.dismiss(ends()));
    }

    private CloseReason ends() {
        return CloseReason.regular("closing", "the world " + Text.quote(name()) + " ends");
    }

    /** Unsubscribes from the frames of the world. */
    @Override
    public void close() {
        port.loop().setGate(FrameGate.OPEN);
        subscription.close();
    }

    private void afterFrame() {
        queueLeaving();
        desk.proceed();
    }

    /**
     * Ends sessions whose clients did not reconnect in time, and answers queries that wait. Called
     * periodically.
     */
    public void checkGrace(long nowNanos) {
        desk.proceed();
        sessions.values().forEach(session -> session.checkGrace(nowNanos));
    }

    /**
     * @param current the tokens that are valid now; sessions with other tokens end
     */
    public void checkTokens(Set<AgentToken> current) {
        sessions.values().forEach(session -> session.checkToken(current));
    }

    /** Returns the number of clients, including disconnected ones that may reconnect. */
    public int clients() {
        return sessions.size();
    }

    /**
     * Describes the clients for reports, in the order of their names. For the event loop's thread
     * only.
     */
    private List<Map<String, Object>> describeClients() {
        return sessions.values().stream()
                .sorted(Comparator.comparing(Session::name))
                .map(Session::describe)
                .toList();
    }

    /**
     * Notifies agents that their allowance has become exhausted or was restored. For the frame
     * loop's thread. Called rarely.
     */
    private void tellWaiting(Allowance allowance) {
        boolean spent = allowance.isSpent();
        publisher.later(
                () -> {
                    List<String> names =
                            sessions.values().stream()
                                    .filter(session -> session.uses(allowance))
                                    .map(Session::name)
                                    .sorted()
                                    .toList();
                    sessions.values().forEach(session -> session.tellWaiting(allowance));
                    String agents =
                            String.join(", ", names.subList(0, Math.min(names.size(), MOST_NAMED)))
                                    + (names.size() > MOST_NAMED ? " and others" : "");
                    if (spent) {
                        services.log()
                                .warn(
                                        "world "
                                                + Text.quote(name())
                                                + " no longer waits for agents in lock-step longer"
                                                + " than a frame: others waited too long for "
                                                + agents
                                                + "; serve --waiting allows more");
                    } else {
                        services.log()
                                .info(
                                        "world "
                                                + Text.quote(name())
                                                + " waits for "
                                                + agents
                                                + " again, until their deadlines");
                    }
                });
    }

    /**
     * Returns the event that notifies an agent in lock-step how long the world waits for it. The
     * event is sent only if the agent's allowance is exhausted.
     */
    Optional<ServerMessage.Event> hurry(@Nullable Turn turn, long frame) {
        return Optional.ofNullable(turn)
                .filter(late -> late.allowance().isSpent())
                .map(late -> waiting(late, frame));
    }

    ServerMessage.Event waiting(Turn turn, long frame) {
        return new ServerMessage.Event(
                frame,
                "waiting",
                Map.of("longest", lockStep.allowances().longestWaitNanos(turn) / 1e9));
    }

    /**
     * Admits a client.
     *
     * @param token token of the client, if the server uses tokens
     * @return the session of the client; the welcome is sent after the world has executed the join
     * @throws CloseReason if the client is refused
     */
    public Session greet(
            Connection connection, Role role, ClientMessage.Hello hello, Optional<AgentToken> token)
            throws CloseReason {
        var session = new Session(this, connection, role, hello, token);
        if (sessions.putIfAbsent(hello.name(), session) != null) {
            throw CloseReason.nameTaken(hello.name());
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
            throw CloseReason.refused(
                    "world-busy", "the world has more to do than fits into a frame", "try again");
        }
        lockStep.comes();
        return session;
    }

    /** Returns the session of that name, including one that has just ended. */
    public Optional<Session> find(String client) {
        return Optional.ofNullable(sessions.get(client));
    }

    Welcome welcome(Session session, ClientMessage.Hello hello, long frame, boolean resumed) {
        AgentLimits limits = services.limits();
        AgentTimeouts timeouts = services.timeouts();
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
                ClientMessage.PROTOCOL,
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

    /**
     * Queues the command by which a client leaves the world. If the queue of the next frame is
     * full, the command waits for a later frame.
     */
    synchronized void leave(Session session, String reason) {
        if (session.role() == Role.AGENT) {
            leaving.add(desk.command(new AgentInput.Leave(session.name(), reason), outcome -> {}));
            queueLeaving();
        } else {
            sessions.remove(session.name());
        }
    }

    /**
     * Queues the waiting leave commands for which there is room. A name is free again once its
     * leave command is queued, because commands of one name are executed in order.
     */
    private synchronized void queueLeaving() {
        while (!leaving.isEmpty() && port.commands().offer(leaving.getFirst())) {
            sessions.remove(leaving.removeFirst().origin());
        }
    }
}
