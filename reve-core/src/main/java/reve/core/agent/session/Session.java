// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Attempts;
import reve.core.agent.embodiment.Outcome;
import reve.core.agent.lockstep.Allowance;
import reve.core.agent.lockstep.Turn;
import reve.core.agent.net.Client;
import reve.core.agent.net.Connection;
import reve.core.agent.net.Counters;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.perception.PerceptionShares;
import reve.core.agent.perception.Senses;
import reve.core.agent.perception.View;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;
import reve.core.agent.publish.CameraRequests;
import reve.core.agent.publish.Perceiver;
import reve.core.agent.publish.PerceptionRequests;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.WorldEvent;

import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.util.BitSet;
import java.util.Optional;
import java.util.Set;

/**
 * One client from its hello to its leave: who it is, what it has asked for, which commands it has
 * given. It outlives a broken connection for as long as its hello asked for; another connection
 * that knows its token goes on with it.
 */
public final class Session implements Client, Perceiver {

    /** Reasons for which a connection ends that are nobody's fault. */
    private static final Set<String> RESUMABLE = Set.of("lost", "idle", "too-slow");

    private final ServedWorld world;
    private final SessionServices services;
    private final AgentLimits limits;
    private final Counters counters;
    private final String name;
    private final Role role;
    private final ClientMessage.Hello hello;
    private final double graceSeconds;
    private final Optional<AgentToken> token;
    private final String secret;

    /** Null for who is not in lock-step. */
    private final @Nullable Turn turn;

    /** The event loop's thread; null for who perceives everything. */
    private @Nullable Senses senses;

    /** The event loop's thread. */
    private final Quota quota;

    private final CameraRequests cameraRequests;
    private final SessionCommands commands;
    private final PerceptionShares.Cost perceptionCost;

    // Guarded by this.
    private final EventLog events;
    private final Resumes resumes;
    private Optional<String> body = Optional.empty();
    private boolean welcomed;

    /** It has a body, and others that are in lock-step keep it waiting. */
    private boolean inRealTime;

    private long lastResultFrame;
    private long brokenNanos;

    /** Null while the connection is broken. Changes with this held. */
    private volatile @Nullable Connection connection;

    private volatile Encoding encoding;
    private volatile PerceptionRequests perceptions;
    private volatile long joinedInFrame;
    private volatile boolean left;

    /**
     * @param token that opened the server for it, if the server takes tokens
     */
    Session(
            ServedWorld world,
            Connection connection,
            Role role,
            ClientMessage.Hello hello,
            Optional<AgentToken> token) {
        this.world = world;
        this.services = world.services();
        this.limits = services.limits();
        AgentTimeouts timeouts = services.timeouts();
        this.counters = services.counters();
        this.name = hello.name();
        this.role = role;
        this.hello = hello;
        this.graceSeconds = Math.min(hello.graceSeconds(), timeouts.grace().toMillis() / 1000.0);
        this.token = token;
        this.secret = AgentToken.newSecret();
        this.events =
                new EventLog(
                        (long) (graceSeconds * 1e9) + 2 * timeouts.idle().toNanos(),
                        EventLog.MAX_BYTES);
        this.resumes = new Resumes(limits.resumes(), System.nanoTime());
        this.perceptionCost = world.publisher().shares().cost(token.map(AgentToken::name));
        this.cameraRequests =
                new CameraRequests(
                        world.cameras(), world.publisher(), services.log(), toString(), this::show);
        this.commands = new SessionCommands(this, world.desk(), limits, counters);
        this.connection = connection;
        this.encoding = connection.encoding();
        this.turn =
                hello.lockStep()
                        .map(
                                wanted ->
                                        new Turn(
                                                name,
                                                wanted,
                                                Math.min(
                                                        (long) (wanted.deadlineSeconds() * 1e9),
                                                        timeouts.deadline().toNanos()),
                                                world.lockStep()
                                                        .allowances()
                                                        .of(
                                                                token.map(AgentToken::name),
                                                                Attempts.network(
                                                                        connection.address()),
                                                                System.nanoTime())))
                        .orElse(null);
        this.quota =
                new Quota(
                        limits.messagesPerSecond(),
                        world.framesPerSecond(),
                        System.nanoTime(),
                        pace());
        this.perceptions = perceptionsOver(connection);
    }

    private PerceptionRequests perceptionsOver(Connection next) {
        var requests = new PerceptionRequests(next.outbox(), counters.perceptions);
        if (turn != null) {
            requests.follow(turn, hello.id());
        }
        return requests;
    }

    @Override
    public String name() {
        return name;
    }

    ServedWorld world() {
        return world;
    }

    Role role() {
        return role;
    }

    @Override
    public Encoding encoding() {
        return encoding;
    }

    @Override
    public PerceptionRequests perceptions() {
        return perceptions;
    }

    @Override
    public PerceptionShares.Cost perceptionCost() {
        return perceptionCost;
    }

    @Override
    public boolean isInLockStep() {
        return turn != null;
    }

    @Override
    public boolean perceives(long frame) {
        return perceptions.isDue(frame);
    }

    @Override
    public PerceptionEncoder encoder() {
        return world.publisher().encoder();
    }

    @Override
    public void wrotePerception(long nanos) {
        perceptionCost.wrote(nanos);
    }

    @Override
    public String worldName() {
        return world.name();
    }

    /** Takes as long for any wrong one. */
    public boolean hasSecret(String claimed) {
        return graceSeconds > 0
                && MessageDigest.isEqual(
                        secret.getBytes(StandardCharsets.US_ASCII),
                        claimed.getBytes(StandardCharsets.UTF_8));
    }

    @Override
    public String toString() {
        return role.wireName() + " " + name;
    }

    // ---- world's thread ----

    /** The agent is in the world, or cannot be: the client is told with the frame. */
    void came(Outcome outcome) {
        if (outcome instanceof Outcome.Joined joined) {
            takePart(joined.frame());
        }
        world.lockStep().came();
        world.publisher().withFrame(() -> joined(outcome));
    }

    private synchronized void takePart(long frame) {
        if (turn != null) {
            turn.begin(frame);
            world.lockStep().add(turn);
        } else if (!left) {
            inRealTime = true;
            world.lockStep().allowances().addRealTime(1);
        }
    }

    // ---- the event loop's thread ----

    /** The agent has its body, or cannot have one. */
    private void joined(Outcome outcome) {
        embodied(outcome);
        if (outcome instanceof Outcome.Joined joined) {
            welcome(Optional.of(joined.body()), joined.frame());
        }
    }

    /** The agent has a body, another one than before perhaps, or cannot have one. */
    @Override
    public void embodied(Outcome outcome) {
        switch (outcome) {
            case Outcome.Joined joined ->
                    senses =
                            joined.sensors().isEmpty()
                                    ? null
                                    : new Senses(joined.id(), joined.sensors());
            case Outcome.Refused refused ->
                    end(
                            CloseReason.refused(
                                    refused.code(), refused.reason(), refused.hint().orElse("")));
            case Outcome.Failed failed -> {
                services.log().error(this + " could not join", failed.cause());
                end(CloseReason.regular("failed", "the server has an error; its log says more"));
            }
            case Outcome.Done done -> {}
            case Outcome.Absent absent -> {}
        }
    }

    /** The client is in the world, from that frame on. */
    synchronized void welcome(Optional<String> itsBody, long frame) {
        if (left) {
            return;
        }
        body = itsBody;
        welcomed = true;
        joinedInFrame = frame;
        if (role == Role.AGENT) {
            counters.joined.increment();
            counters.agents.increment();
        }
        perceptions.notBefore(frame);
        offer(world.welcome(this, hello, frame, false));
        world.hurry(turn, frame).ifPresent(this::offer);
        world.publisher().admit(this);
        services.log()
                .info(
                        this
                                + " joined"
                                + body.map(item -> " with body " + Text.quote(item)).orElse(""));
    }

    /** Tells how long the world waits for the agent, if that is because of this allowance. */
    void tellWaiting(Allowance allowance) {
        Turn waitedFor = turn;
        if (waitedFor == null || !has(allowance)) {
            return;
        }
        synchronized (this) {
            if (!welcomed || left) {
                return; // the welcome tells it
            }
        }
        send(world.waiting(waitedFor, world.publisher().published()));
    }

    /** Whether its agent is in lock-step and uses up that allowance. */
    boolean has(Allowance allowance) {
        return turn != null && turn.allowance() == allowance;
    }

    /** True if it perceives only what the sensors of its body sense. */
    @Override
    public boolean hasSensors() {
        return senses != null;
    }

    /** What it perceives of the newest frame. */
    @Override
    public View look(Observatory world) {
        return senses == null ? world.everything() : senses.look(world);
    }

    @Override
    public boolean wantsRelations(long frame) {
        return perceptions.wantsRelations(frame);
    }

    @Override
    public Optional<Set<ItemId>> sensedIn(long frame) {
        return senses == null ? Optional.empty() : senses.sensedIn(frame);
    }

    @Override
    public View relate(View view, Optional<Set<ItemId>> fresh) {
        return senses == null || fresh.isEmpty() ? view : senses.relate(view, fresh.get());
    }

    /**
     * Which fields of an event its sensors let it know, see {@link Senses#hear}; all without
     * sensors. What a fault was in detail may name files of the server, and is for who controls the
     * world alone.
     */
    @Override
    public Optional<BitSet> hear(WorldEvent event, EventSubjects subjects, Observatory world) {
        if (senses == null) {
            var told = new BitSet();
            told.set(0, event.fields().size());
            if (role != Role.CONTROL && event.type().equals(Senses.FAULT)) {
                int place = 0;
                for (String field : event.fields().keySet()) {
                    told.set(place++, !field.equals("message"));
                }
            }
            return Optional.of(told);
        }
        return senses.hear(event, subjects, world);
    }

    /** See {@link Observatory#reach}. */
    @Override
    public boolean reach(Observatory world, double[] lows, double[] highs, int at) {
        return senses != null && senses.reach(world, lows, highs, at);
    }

    /** Tells what happened in a frame. */
    @Override
    public void tell(HeardEvent.Told event) {
        if (event.message().frame() < joinedInFrame) {
            return;
        }
        if (graceSeconds > 0) {
            synchronized (this) {
                events.add(event, System.nanoTime());
            }
        }
        offerEvent(event.bytes(), event.message().frame());
    }

    // ---- its connection's reader ----

    /** True if one more message of it may be taken now. */
    @Override
    public boolean hasQuota() {
        return quota.hasLeft(System.nanoTime(), pace());
    }

    /**
     * Frames, for who keeps pace with the world: such a client has more to say where that is fast.
     */
    private long pace() {
        return turn == null ? 0 : world.publisher().published();
    }

    /** A message of it is taken. */
    @Override
    public void count() {
        quota.take();
    }

    /** The agent has done what it does in this round. */
    @Override
    public void ready(ClientMessage.Ready ready) throws BadMessage {
        requireLockStep(ready.id());
        endRound(ready);
    }

    void requireLockStep(long id) throws BadMessage {
        if (turn == null) {
            throw new BadMessage(
                    id,
                    "not-lock-step",
                    "nobody waits for " + this,
                    "say hello with \"time\":{\"mode\":\"lock-step\"} to be waited for");
        }
    }

    /** Ends the agent's round; does nothing if the agent is not in lock-step. */
    void endRound(ClientMessage.Ready ready) {
        if (turn != null) {
            if (ready.frame().isPresent()) {
                turn.ready(
                        ready.frame().getAsLong(),
                        world.publisher().published(),
                        System.nanoTime());
            } else {
                turn.ready(System.nanoTime());
            }
            world.lockStep().changed();
        }
    }

    @Override
    public void perceive(ClientMessage.Perceive perceive) throws BadMessage {
        perceptions.ask(perceive, world.publisher().published());
    }

    /** Has a picture taken by a camera of its body, and sent. */
    @Override
    public void look(ClientMessage.Look look) throws BadMessage {
        Senses known = senses;
        Sensor camera =
                Optional.ofNullable(known)
                        .flatMap(body -> body.camera(look.sensor()))
                        .orElseThrow(
                                () ->
                                        new BadMessage(
                                                look.id(),
                                                "no-such-camera",
                                                this
                                                        + " has no camera "
                                                        + Text.quote(look.sensor()),
                                                "the world file says which sensors a body has"));
        cameraRequests.take(look, known.body(), camera);
    }

    @Override
    public void request(ClientMessage.Request request) throws BadMessage {
        commands.request(request);
    }

    private void show(ServerMessage picture) {
        boolean room;
        synchronized (this) {
            room = offer(picture);
        }
        if (!room) {
            end(CloseReason.cut("too-slow", "a picture waits to be read, and too much else"));
        }
    }

    // ---- the connection ----

    /**
     * Goes on over another connection, with the events since the last frame that it has seen.
     *
     * @throws CloseReason if it was resumed too often
     */
    public void resume(Connection next, long frameSeen) throws CloseReason {
        Connection previous;
        synchronized (this) {
            if (!resumes.take(System.nanoTime())) {
                throw CloseReason.refused(
                        "resumed-too-often",
                        "the session of "
                                + Text.quote(name)
                                + " was resumed "
                                + limits.resumes()
                                + " times at short intervals; it may"
                                + " be resumed "
                                + Resumes.PER_SECOND
                                + " times a second",
                        "try again in " + 1.0 / Resumes.PER_SECOND + " s");
            }
            previous = connection;
            connection = next;
            services.kept().keepNoLonger(this);
            encoding = next.encoding();
            perceptions = perceptionsOver(next);
            perceptions.notBefore(lastResultFrame);
            if (turn != null) {
                turn.comeBack();
            }
            next.outbox()
                    .begin(
                            world.welcome(this, hello, world.publisher().published(), true)
                                    .in(encoding),
                            events.after(frameSeen, encoding),
                            encoding);
            world.hurry(turn, world.publisher().published())
                    .ifPresent(event -> next.outbox().offer(event.in(encoding)));
        }
        world.lockStep().changed();
        if (previous != null) {
            previous.replace(
                    CloseReason.regular("resumed", "another connection goes on with this session"));
        }
        services.log().info(this + " is back");
    }

    /** A connection has ended; if it was this session's, the session breaks or ends. */
    @Override
    public void disconnected(Connection ended, CloseReason why) {
        synchronized (this) {
            if (connection != ended || left) {
                return;
            }
            connection = null;
            if (welcomed
                    && graceSeconds > 0
                    && RESUMABLE.contains(why.code())
                    && (token.isPresent() || services.kept().keep(this))) {
                brokenNanos = System.nanoTime();
                if (turn != null) {
                    turn.breakOff(brokenNanos);
                    world.lockStep().changed();
                }
                return;
            }
        }
        leave(why.code());
    }

    /** Called every now and then; leaves when nobody came back in time. */
    void checkGrace(long nowNanos) {
        synchronized (this) {
            if (connection != null || left || nowNanos - brokenNanos < graceSeconds * 1e9) {
                return;
            }
        }
        leave("lost");
    }

    /** Called every now and then; ends the session when its token opens nothing any more. */
    void checkToken(Set<AgentToken> current) {
        if (token.isEmpty() || current.contains(token.get())) {
            return;
        }
        CloseReason why =
                CloseReason.cut(
                        "token-revoked", "your token was revoked or changed, or has expired");
        end(why);
        leave(why.code()); // nothing new if it had a connection
    }

    private void leave(String reason) {
        synchronized (this) {
            if (left) {
                return;
            }
            left = true;
            if (welcomed && role == Role.AGENT) {
                counters.agents.decrement();
            }
            services.kept().keepNoLonger(this);
            if (inRealTime) {
                world.lockStep().allowances().addRealTime(-1);
            }
        }
        if (turn != null) {
            world.lockStep().remove(turn, System.nanoTime());
        }
        world.publisher().dismiss(this); // before others may have its name
        world.leave(this, reason);
    }

    synchronized ServerMessage.@Nullable Ticket ticket() {
        return graceSeconds > 0 ? new ServerMessage.Ticket(secret, graceSeconds) : null;
    }

    Optional<ServerMessage.Rhythm> rhythm() {
        return Optional.ofNullable(turn)
                .map(
                        followed ->
                                new ServerMessage.Rhythm(
                                        followed.wanted().every(), followed.deadlineNanos() / 1e9));
    }

    @Override
    public synchronized Optional<String> body() {
        return body;
    }

    /**
     * Queues the result of a command that took effect in a frame; perceptions that follow are not
     * older than that. With this held.
     *
     * @return false if too much waits to be read
     */
    boolean offerResult(ServerMessage result, long frame) {
        lastResultFrame = Math.max(lastResultFrame, frame);
        perceptions.notBefore(lastResultFrame);
        return offer(result);
    }

    void send(ServerMessage message) {
        Connection now = connection;
        if (now != null) {
            now.send(message);
        }
    }

    /** Ends its connection, if it has one. */
    void end(CloseReason why) {
        Connection now = connection;
        if (now != null) {
            now.end(why);
        }
    }

    private boolean offer(ServerMessage message) {
        return offer(message.in(encoding));
    }

    /**
     * @return false if the client has let too much pile up
     */
    boolean offer(byte[] line) {
        Connection now = connection;
        return now == null || now.outbox().offer(line);
    }

    /** So many events, at most, happened in these frames and are not told. Event loop's thread. */
    @Override
    public void miss(long events, long first, long last) {
        if (last < joinedInFrame) {
            return;
        }
        if (graceSeconds > 0) {
            synchronized (this) {
                this.events.forget(last);
            }
        }
        Connection now = connection;
        if (now != null) {
            now.outbox().miss(events, Math.max(first, joinedInFrame), last);
        }
    }

    /**
     * Frames may follow each other faster than what happened is written, so a full outbox is
     * written before events are missed.
     */
    private void offerEvent(byte[] line, long frame) {
        Connection now = connection;
        if (now != null && !now.outbox().offer(line, frame)) {
            now.write();
            if (!now.outbox().offer(line, frame)) {
                now.outbox().miss(frame);
            }
        }
    }
}
