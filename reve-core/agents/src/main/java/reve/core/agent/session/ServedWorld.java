// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Rights;
import reve.core.agent.control.Clients;
import reve.core.agent.control.ControlDesk;
import reve.core.agent.embodiment.AgentCommand;
import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.embodiment.Outcome;
import reve.core.agent.lockstep.Allowance;
import reve.core.agent.lockstep.Allowances;
import reve.core.agent.lockstep.LockStep;
import reve.core.agent.lockstep.Turn;
import reve.core.agent.net.Connection;
import reve.core.agent.port.Cameras;
import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.SessionNotes;
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
import reve.core.world.ItemId;
import reve.core.world.SnapshotRing;

import java.time.Duration;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.Deque;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
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

    /** The last time at which a client was in the world, or the start of the service [ns]. */
    private volatile long usedNanos = System.nanoTime();

    /**
     * @param waiting the way in which the world's thread waits for agents in lock-step
     */
    public ServedWorld(SessionServices services, WorldPort port, LockStep.Waiting waiting) {
        this.services = services;
        this.port = port;
        this.publisher = new Publisher(port, services.log(), this::afterFrame, services.wake());
        this.desk =
                new ControlDesk(
                        port,
                        publisher,
                        services.log(),
                        new Described(),
                        services.audit(),
                        services.isShared());
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

    /** Returns the place for notes about the sessions. For any thread. */
    SessionNotes notes() {
        return port.notes();
    }

    /**
     * Delays the first frame until this number of agents waits to join. Call this method before the
     * loop runs.
     */
    public void expectAgents(int agents) {
        lockStep.expect(agents);
    }

    /** Returns the number of agents in lock-step. For any thread. */
    public int inLockStep() {
        return lockStep.size();
    }

    SnapshotRing snapshots() {
        return port.snapshots();
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
     * Returns whether the world has no clients, and had none for a time. A session whose client may
     * reconnect counts as a client. For any thread.
     */
    public boolean isUnused(Duration time) {
        return sessions.isEmpty() && System.nanoTime() - usedNanos >= time.toNanos();
    }

    /**
     * Ends the world if it is unused; it then admits no more clients. For the event loop's thread.
     *
     * @return whether this call has ended the world
     */
    public boolean endIfUnused(Duration time) {
        if (ended || !isUnused(time)) {
            return false;
        }
        ended = true;
        return true;
    }

    /**
     * Ends the world and all sessions, also those whose clients may reconnect. For the event loop's
     * thread, while the world's thread waits.
     *
     * @param next HOST:PORT of the server that the clients shall ask for the world; empty if the
     *     world ends
     * @return the sessions that the other server can continue
     */
    public List<CarriedSession> dismiss(Optional<String> next) {
        ended = true;
        publisher.tellAll();
        if (next.isEmpty()) {
            sessions.values().forEach(session -> session.dismiss(ends()));
            return List.of();
        }
        CloseReason why = CloseReason.moving(name(), next.get());
        List<CarriedSession> carried = new ArrayList<>();
        sessions.values().stream()
                .sorted(Comparator.comparing(Session::name))
                .forEach(
                        session -> {
                            Optional<CarriedSession> away =
                                    session.carryAway(
                                            why, desk.embodiment().granted(session.name()));
                            away.ifPresentOrElse(carried::add, () -> session.dismiss(why));
                        });
        return carried;
    }

    /**
     * Continues sessions of another server, which wait for their clients as after a broken
     * connection. Agents whose sessions cannot continue leave in the next frame. For the world's
     * thread, before its first frame.
     *
     * @param carried the sessions; the world has their bodies
     * @param tokens the tokens that are valid now; empty if the server uses none
     */
    public void restore(List<CarriedSession> carried, Optional<Set<AgentToken>> tokens) {
        for (CarriedSession each : carried) {
            Optional<SessionState> state = Optional.empty();
            try {
                state = Optional.of(SessionState.read(each, port.loop().frame()));
            } catch (IllegalArgumentException unreadable) {
                services.log()
                        .warn(
                                "world "
                                        + name()
                                        + ": "
                                        + unreadable.getMessage()
                                        + "; its agent joins again");
            }
            Optional<Embodiment.Granted> body =
                    state.isPresent()
                            ? state.get().body()
                            : each.body().isEmpty()
                                    ? Optional.empty()
                                    : Optional.of(
                                            new Embodiment.Granted(
                                                    new ItemId(each.body().getAsLong()),
                                                    OptionalInt.empty()));
            Optional<AgentToken> token = state.flatMap(known -> tokenOf(known, tokens));
            boolean isPermitted =
                    state.isPresent()
                            && (token.isPresent()
                                    || tokens.isEmpty() && state.get().tokenSha256().isEmpty());
            long frame = port.loop().frame();
            Rights rights = token.map(AgentToken::rights).orElse(Rights.ALL);
            Optional<Outcome.Joined> joined =
                    body.flatMap(
                            granted ->
                                    desk.embodiment()
                                            .restore(
                                                    port.loop().world(),
                                                    frame,
                                                    each.client(),
                                                    granted,
                                                    rights));
            if (!isPermitted) {
                String why = state.isPresent() ? "token-revoked" : "lost";
                joined.ifPresent(_ -> leave(each.client(), why));
            } else if (state.get().role() != Role.AGENT || joined.isPresent()) {
                var session =
                        new Session(
                                this,
                                state.get(),
                                token,
                                each.since().isPresent() ? frame : Long.MAX_VALUE);
                sessions.put(each.client(), session);
                session.restore(joined, frame);
            }
        }
    }

    /** Returns the token of a session of another server, if it still permits the session. */
    private Optional<AgentToken> tokenOf(SessionState state, Optional<Set<AgentToken>> tokens) {
        return tokens.flatMap(
                known ->
                        known.stream()
                                .filter(
                                        token ->
                                                state.tokenSha256()
                                                        .filter(token.sha256()::equals)
                                                        .isPresent())
                                .filter(token -> token.name().equals(state.hello().name()))
                                .filter(token -> token.rights().roles().contains(state.role()))
                                .filter(token -> token.rights().opensWorld(name()))
                                .filter(
                                        token ->
                                                state.hello().lockStep().isEmpty()
                                                        || token.rights().lockStep())
                                .findFirst());
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
        if (!sessions.isEmpty()) {
            usedNanos = nowNanos;
        }
        sessions.values().forEach(session -> session.checkGrace(nowNanos));
    }

    /**
     * Ends the sessions whose tokens are not valid.
     *
     * @param current the tokens that are valid now; sessions with other tokens end
     */
    public void checkTokens(Set<AgentToken> current) {
        sessions.values().forEach(session -> session.checkToken(current));
    }

    /** Returns the number of clients, including disconnected ones that may reconnect. */
    public int clients() {
        return sessions.size();
    }

    /** The clients as reports describe them. */
    private final class Described implements Clients {
        @Override
        public List<Map<String, Object>> describe() {
            return sessions.values().stream()
                    .sorted(Comparator.comparing(Session::name))
                    .map(Session::describe)
                    .toList();
        }

        @Override
        public Optional<Map<String, Object>> perceived(String agent) {
            return find(agent)
                    .filter(session -> session.role() == Role.AGENT)
                    .map(Session::describePerception);
        }

        @Override
        public void measureRoundTrips() {
            sessions.values().forEach(Session::measureRoundTrip);
        }

        @Override
        public void noteBodies() {
            sessions.values().forEach(Session::noteBody);
        }
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
        usedNanos = System.nanoTime();
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
                told,
                session.cameras());
    }

    private static double seconds(Duration duration) {
        return duration.toMillis() / 1000.0;
    }

    /**
     * Queues the command by which a client leaves the world. The command waits for a later frame if
     * the queue of the next frame is full.
     */
    synchronized void leave(Session session, String reason) {
        if (session.role() == Role.AGENT) {
            leave(session.name(), reason);
        } else {
            usedNanos = System.nanoTime();
            sessions.remove(session.name());
        }
    }

    private synchronized void leave(String agent, String reason) {
        leaving.add(desk.command(new AgentInput.Leave(agent, reason), outcome -> {}));
        queueLeaving();
    }

    /**
     * Queues the waiting leave commands, as far as the queue has room. A name is free again once
     * its leave command is queued, because commands of one name are executed in order.
     */
    private synchronized void queueLeaving() {
        while (!leaving.isEmpty() && port.commands().offer(leaving.getFirst())) {
            usedNanos = System.nanoTime();
            sessions.remove(leaving.removeFirst().origin());
        }
    }
}
