// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Attempts;
import reve.core.agent.auth.Rights;
import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.embodiment.Outcome;
import reve.core.agent.lockstep.Allowance;
import reve.core.agent.lockstep.Turn;
import reve.core.agent.net.Client;
import reve.core.agent.net.Connection;
import reve.core.agent.net.Counters;
import reve.core.agent.net.Outbox;
import reve.core.agent.perception.EventSubjects;
import reve.core.agent.perception.HeardEvent;
import reve.core.agent.perception.Observatory;
import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.perception.PerceptionShares;
import reve.core.agent.perception.View;
import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.SessionNote;
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
import reve.core.world.WorldEvent;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.util.BitSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BooleanSupplier;

/**
 * One client from its hello until it leaves, with its identity, requests and commands. The session
 * continues after a broken connection for the time that the client requested. A new connection that
 * presents the session token resumes it. For any thread, unless stated otherwise.
 */
public final class Session implements Client, Perceiver {

    /**
     * Codes of the reasons that allow a session to be resumed. They state why its connection ended.
     */
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
    private final String secretSha256;

    /** The session token; null until a client has presented the token of a restored session. */
    private volatile @Nullable String secret;

    /** Network address of the client, for limits by address. */
    private final ByteBuffer network;

    private final SessionSenses senses;
    private final SessionPace pace;
    private final SessionOutput output;

    /** The quota of messages. Only the event loop's thread uses it. */
    private final Quota quota;

    private final CameraRequests cameraRequests;
    private final SessionCommands commands;
    private final PerceptionShares.Cost perceptionCost;

    // The limit on resumes of this session. Guarded by this object's lock.
    private final Resumes resumes;
    private Optional<String> body = Optional.empty();
    private boolean welcomed;
    private boolean left;
    private long brokenNanos;

    /**
     * The last frame of a lost server that the world has, until the client resumes the session. The
     * client may have seen later frames, which are lost.
     */
    private long lastKept = Long.MAX_VALUE;

    /**
     * @param token token of the client, if the server uses tokens
     */
    Session(
            ServedWorld world,
            Connection connection,
            Role role,
            ClientMessage.Hello hello,
            Optional<AgentToken> token) {
        this(
                world,
                Optional.of(connection),
                role,
                hello,
                token,
                AgentToken.newSecret(),
                Attempts.network(connection.address()));
    }

    /**
     * Creates a session that another server has begun. It waits for a connection.
     *
     * @param lastKept the last frame of the other server, if it was lost
     */
    Session(ServedWorld world, SessionState state, Optional<AgentToken> token, long lastKept) {
        this(
                world,
                Optional.empty(),
                state.role(),
                state.hello(),
                token,
                state.secretSha256(),
                ByteBuffer.wrap(state.network()));
        // The other server has sent the events of the last frame, which is published again here.
        long next = world.publisher().published() + 1;
        output.restore(next, state.resultFrame(), state.events(), state.forgottenFrame());
        state.results()
                .forEach(
                        result ->
                                commands.log()
                                        .finish(
                                                result instanceof ServerMessage.Accepted accepted
                                                        ? accepted.id()
                                                        : ((ServerMessage.Refused) result).id(),
                                                result));
        commands.log().forget(state.forgottenId());
        brokenNanos = System.nanoTime() - (long) (state.brokenSeconds() * 1e9);
        this.lastKept = lastKept;
    }

    /**
     * @param connection empty for a session that another server has begun
     * @param identity the session token, or its hash if there is no connection
     */
    private Session(
            ServedWorld world,
            Optional<Connection> connection,
            Role role,
            ClientMessage.Hello hello,
            Optional<AgentToken> token,
            String identity,
            ByteBuffer network) {
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
        this.secret = connection.isPresent() ? identity : null;
        this.secretSha256 = connection.isPresent() ? AgentToken.hash(identity) : identity;
        this.network = network;
        this.resumes = new Resumes(limits.resumes(), System.nanoTime());
        this.perceptionCost = world.publisher().shares().cost(token.map(AgentToken::name));
        this.cameraRequests =
                new CameraRequests(
                        world.cameras(), world.publisher(), services.log(), toString(), this::show);
        this.commands = new SessionCommands(this, world.desk(), limits, counters);
        this.senses = new SessionSenses(role);
        this.pace = new SessionPace(world.lockStep(), turn(timeouts));
        this.output =
                new SessionOutput(
                        connection,
                        graceSeconds > 0
                                ? (long) (graceSeconds * 1e9) + 2 * timeouts.idle().toNanos()
                                : 0,
                        this::requestsOver);
        this.quota =
                new Quota(
                        limits.messagesPerSecond(),
                        world.framesPerSecond(),
                        System.nanoTime(),
                        framesOfQuota());
    }

    private @Nullable Turn turn(AgentTimeouts timeouts) {
        if (hello.lockStep().isEmpty()) {
            return null;
        }
        ClientMessage.LockStep wanted = hello.lockStep().get();
        return new Turn(
                name,
                wanted,
                Math.min((long) (wanted.deadlineSeconds() * 1e9), timeouts.deadline().toNanos()),
                world.lockStep()
                        .allowances()
                        .of(token.map(AgentToken::name), network, System.nanoTime()));
    }

    private PerceptionRequests requestsOver(Optional<Connection> connection) {
        if (connection.isEmpty()) { // requests are made over the next connection
            return new PerceptionRequests(new Outbox(0, 0, () -> {}), counters.perceptions);
        }
        var requests = new PerceptionRequests(connection.get().outbox(), counters.perceptions);
        pace.follow(requests, hello.id());
        return requests;
    }

    @Override
    public String name() {
        return name;
    }

    ServedWorld world() {
        return world;
    }

    /** Returns the rights of the client's token; all rights if the server uses no tokens. */
    Rights rights() {
        return token.map(AgentToken::rights).orElse(Rights.ALL);
    }

    Role role() {
        return role;
    }

    @Override
    public Encoding encoding() {
        return output.encoding();
    }

    @Override
    public PerceptionRequests perceptions() {
        return output.perceptions();
    }

    @Override
    public PerceptionShares.Cost perceptionCost() {
        return perceptionCost;
    }

    @Override
    public boolean isInLockStep() {
        return pace.isLockStep();
    }

    @Override
    public boolean perceives(long frame) {
        return output.perceptions().isDue(frame);
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

    /** Returns whether {@code claimed} is the session token; compares in constant time. */
    public boolean hasSecret(String claimed) {
        boolean isRight =
                graceSeconds > 0
                        && MessageDigest.isEqual(
                                secretSha256.getBytes(StandardCharsets.US_ASCII),
                                AgentToken.hash(claimed).getBytes(StandardCharsets.US_ASCII));
        if (isRight) {
            secret = claimed;
        }
        return isRight;
    }

    /** Returns the names of the cameras of the client's body. For the event loop's thread only. */
    List<String> cameras() {
        return senses.cameras();
    }

    /**
     * Describes the client for reports: name, role, body, and how it perceives. For the event
     * loop's thread only.
     */
    synchronized Map<String, Object> describe() {
        var fields = new LinkedHashMap<String, Object>();
        fields.put("name", name);
        fields.put("role", role.wireName());
        body.ifPresent(item -> fields.put("body", item));
        fields.put("connected", !output.isBroken());
        fields.put("limited", senses.areLimited());
        fields.put("lockStep", pace.isLockStep());
        List<String> cameras = senses.cameras();
        if (!cameras.isEmpty()) {
            fields.put("cameras", cameras);
        }
        output.roundTripSeconds().ifPresent(seconds -> fields.put("roundTripSeconds", seconds));
        return fields;
    }

    /** Describes what the client perceived last, for reports. For the event loop's thread only. */
    Map<String, Object> describePerception() {
        return senses.describe();
    }

    /** Measures the round-trip time to the client, if the client is in the world. */
    void measureRoundTrip() {
        synchronized (this) {
            if (!welcomed || left) {
                return;
            }
        }
        output.measureRoundTrip(); // outside the lock, because it may end the connection
    }

    @Override
    public String toString() {
        return role.wireName() + " " + name;
    }

    /**
     * Handles the outcome of the join. The outcome is sent to the client together with the frame.
     * For the world's thread only.
     */
    void came(Outcome outcome) {
        if (outcome instanceof Outcome.Joined joined) {
            pace.begin(joined.frame());
            noteBody();
        }
        world.lockStep().came();
        world.publisher().withFrame(() -> joined(outcome));
    }

    /** Handles the outcome of the join on the event loop's thread. */
    private void joined(Outcome outcome) {
        embodied(outcome);
        if (outcome instanceof Outcome.Joined joined) {
            welcome(Optional.of(joined.body()), joined.frame());
        }
    }

    /**
     * Handles the assignment of a body, which may replace an earlier body. A refusal ends the
     * session.
     */
    @Override
    public void embodied(Outcome outcome) {
        switch (outcome) {
            case Outcome.Joined joined -> senses.embody(joined);
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

    /**
     * Sends the welcome. The client is in the world from this frame on. For the event loop's thread
     * only.
     */
    synchronized void welcome(Optional<String> newBody, long frame) {
        if (left) {
            return;
        }
        body = newBody;
        welcomed = true;
        if (role == Role.AGENT) {
            counters.joined.increment();
            counters.agents.increment();
        } else {
            note(Optional.empty());
        }
        output.beginAt(frame);
        output.welcomed(role, world.name(), name);
        output.offer(world.welcome(this, hello, frame, false));
        world.hurry(pace.turn(), frame).ifPresent(output::offer);
        world.publisher().admit(this);
        services.log()
                .info(
                        this
                                + " joined"
                                + body.map(item -> " with body " + Text.quote(item)).orElse(""));
    }

    /**
     * Notifies the agent for how long the world waits for it. Does nothing if the agent does not
     * use the given allowance.
     */
    void tellWaiting(Allowance allowance) {
        Turn waitedFor = pace.turn();
        if (waitedFor == null || !uses(allowance)) {
            return;
        }
        synchronized (this) {
            if (!welcomed || left) {
                return; // the welcome will contain this time, or the agent has left
            }
        }
        send(world.waiting(waitedFor, world.publisher().published()));
    }

    /** Returns whether the agent is in lock-step and uses this allowance. */
    boolean uses(Allowance allowance) {
        return pace.uses(allowance);
    }

    @Override
    public boolean hasSensors() {
        return senses.areLimited();
    }

    @Override
    public Optional<View> look(Observatory observatory, BooleanSupplier isTimeLeft) {
        return senses.look(observatory, isTimeLeft);
    }

    @Override
    public boolean wantsRelations(long frame) {
        return output.perceptions().wantsRelations(frame);
    }

    @Override
    public Optional<Set<ItemId>> sensedIn(long frame) {
        return senses.sensedIn(frame);
    }

    @Override
    public View relate(View view, Optional<Set<ItemId>> fresh) {
        return senses.relate(view, fresh);
    }

    @Override
    public boolean needsSight() {
        return senses.needsSight();
    }

    @Override
    public Optional<BitSet> hear(
            WorldEvent event, EventSubjects subjects, Observatory observatory, boolean searches) {
        return senses.hear(event, subjects, observatory, searches);
    }

    @Override
    public boolean reach(Observatory observatory, double[] lows, double[] highs, int at) {
        return senses.reach(observatory, lows, highs, at);
    }

    @Override
    public void tell(HeardEvent.Told event) {
        output.tell(event);
    }

    @Override
    public void miss(long events, long first, long last) {
        output.miss(events, first, last);
    }

    @Override
    public boolean hasQuota() {
        return quota.hasLeft(System.nanoTime(), framesOfQuota());
    }

    /**
     * Returns the frame number for the quota. The quota of an agent in lock-step also grows with
     * frames, so that it may send more messages in a faster world.
     */
    private long framesOfQuota() {
        return pace.isLockStep() ? world.publisher().published() : 0;
    }

    @Override
    public void count() {
        quota.take();
    }

    @Override
    public void ready(ClientMessage.Ready ready) throws BadMessage {
        requireLockStep(ready.id());
        endRound(ready);
    }

    void requireLockStep(long id) throws BadMessage {
        pace.requireLockStep(id, this);
    }

    /** Ends the current round of an agent in lock-step. Does nothing for other agents. */
    void endRound(ClientMessage.Ready ready) {
        pace.endRound(ready, world.publisher().published());
    }

    @Override
    public void perceive(ClientMessage.Perceive perceive) throws BadMessage {
        output.perceptions().ask(perceive, world.publisher().published());
    }

    @Override
    public void look(ClientMessage.Look look) throws BadMessage {
        if (look.item().isEmpty()) {
            senses.look(look, cameraRequests, this);
            return;
        }
        String item = look.item().get();
        if (role == Role.CONTROL) {
            BodyCamera found = BodyCamera.find(world.snapshots(), look, item);
            lookLater(() -> cameraRequests.take(look, found.body(), found.camera()));
        } else if (body().filter(item::equals).isPresent()) {
            lookLater(() -> senses.look(look, cameraRequests, this));
        } else {
            throw new BadMessage(
                    look.id(),
                    "not-permitted",
                    this + " may use the cameras of its own body only",
                    "leave item out, or say hello with \"role\":\"control\"");
        }
    }

    private interface Looking {
        void begin() throws BadMessage;
    }

    /** Requests a picture on the event loop's thread. */
    private void lookLater(Looking looking) {
        world.publisher()
                .later(
                        () -> {
                            try {
                                looking.begin();
                            } catch (BadMessage e) {
                                show(e.error());
                            }
                        });
    }

    @Override
    public void request(ClientMessage.Request request) throws BadMessage {
        commands.request(request);
    }

    private void show(ServerMessage picture) {
        boolean room;
        synchronized (this) {
            // The lock ensures that no other connection resumes the session meanwhile.
            room = output.offer(picture);
        }
        if (!room) {
            end(CloseReason.cut("too-slow", "a picture waits to be read, and too much else"));
        }
    }

    /**
     * Resumes the session over another connection, and sends the events since the last frame that
     * the client saw.
     *
     * @throws CloseReason if the session was resumed too often
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
            services.kept().keepNoLonger(this);
            previous = output.switchTo(next);
            pace.comeBack();
            output.welcomed(role, world.name(), name);
            output.begin(
                    world.welcome(this, hello, world.publisher().published(), true),
                    Math.min(frameSeen, lastKept));
            lastKept = Long.MAX_VALUE;
            world.hurry(pace.turn(), world.publisher().published()).ifPresent(output::offer);
        }
        world.lockStep().changed();
        if (previous != null) {
            previous.replace(
                    CloseReason.regular("resumed", "another connection goes on with this session"));
        }
        services.log().info(this + " is back");
    }

    /**
     * Handles the end of a connection. The session waits for a new connection or ends if this
     * connection was its current one.
     */
    @Override
    public void disconnected(Outbox outbox, CloseReason why) {
        boolean leaves;
        synchronized (this) {
            if (!output.isSentBy(outbox)) {
                return;
            }
            leaves = !left;
            if (leaves) {
                output.breakOff();
                if (welcomed
                        && graceSeconds > 0
                        && RESUMABLE.contains(why.code())
                        && (token.isPresent() || services.kept().keep(this))) {
                    brokenNanos = System.nanoTime();
                    pace.breakOff(brokenNanos);
                    leaves = false;
                }
            }
        }
        commands.forgetQueries();
        if (leaves) {
            leave(why.code());
        }
    }

    /** Ends the session if the client did not reconnect in time. Called periodically. */
    void checkGrace(long nowNanos) {
        synchronized (this) {
            if (left || !output.isBroken() || nowNanos - brokenNanos < graceSeconds * 1e9) {
                return;
            }
        }
        leave("lost");
    }

    /** Ends the session if its token is no longer valid. Called periodically. */
    void checkToken(Set<AgentToken> current) {
        if (token.isEmpty() || current.contains(token.get())) {
            return;
        }
        CloseReason why =
                CloseReason.cut(
                        "token-revoked", "your token was revoked or changed, or has expired");
        dismiss(why); // the leave has no effect if the session has a connection again
    }

    /**
     * Ends the session on this server, so that another one continues it. The world makes no more
     * frames here.
     *
     * @param granted the body of the client
     * @return empty if the session cannot be resumed; it is then not ended
     */
    Optional<CarriedSession> carryAway(CloseReason why, Optional<Embodiment.Granted> granted) {
        CarriedSession carried;
        synchronized (this) {
            if (left || !welcomed || graceSeconds <= 0 || role == Role.AGENT && granted.isEmpty()) {
                return Optional.empty();
            }
            left = true; // the end of the connection does not end the session
            if (role == Role.AGENT) {
                counters.agents.decrement();
            }
            services.kept().keepNoLonger(this);
            double brokenSeconds = output.isBroken() ? (System.nanoTime() - brokenNanos) / 1e9 : 0;
            carried = state(granted, brokenSeconds, output.events()).write();
        }
        end(why);
        world.publisher().dismiss(this);
        pace.leave();
        return Optional.of(carried);
    }

    /** Returns the state of the session. The caller must hold the lock of this object. */
    private SessionState state(
            Optional<Embodiment.Granted> granted,
            double brokenSeconds,
            List<ServerMessage.Event> events) {
        return new SessionState(
                secretSha256,
                role,
                hello,
                token.map(AgentToken::sha256),
                bytes(network),
                granted,
                brokenSeconds,
                output.lastResultFrame(),
                commands.log().results(),
                commands.log().highestForgotten(),
                events,
                output.lastForgotten());
    }

    /** Returns whether the store of the world has notes about this session. For any thread. */
    boolean isNoted() {
        return graceSeconds > 0 && world.notes().areKept();
    }

    /**
     * Notes the session with the body that the client has now. For the world's thread, between the
     * executions of commands.
     */
    void noteBody() {
        if (isNoted() && role == Role.AGENT) {
            Optional<Embodiment.Granted> granted = world.desk().embodiment().granted(name);
            if (granted.isPresent()) {
                note(granted);
            }
        }
    }

    /** Notes that the session can be continued, unless it has ended. */
    private synchronized void note(Optional<Embodiment.Granted> granted) {
        if (isNoted() && !left) {
            // The loss of this server will break the connection, so the grace begins then.
            world.notes().add(new SessionNote.Began(state(granted, 0, List.of()).write()));
        }
    }

    private static byte[] bytes(ByteBuffer buffer) {
        byte[] bytes = new byte[buffer.remaining()];
        buffer.duplicate().get(bytes);
        return bytes;
    }

    /**
     * Continues a session of another server. For the world's thread, before its first frame.
     *
     * @param joined the body of the client, if it has one
     * @param frame last frame of the world
     */
    void restore(Optional<Outcome.Joined> joined, long frame) {
        synchronized (this) {
            body = joined.map(Outcome.Joined::body);
            welcomed = true;
        }
        if (role == Role.AGENT) {
            counters.agents.increment();
            pace.begin(frame);
            pace.breakOff(System.nanoTime());
            noteBody();
        } else {
            note(Optional.empty());
        }
        world.publisher()
                .later(
                        () -> {
                            joined.ifPresent(senses::embody);
                            world.publisher().admit(this);
                        });
    }

    /** Ends the session, and its connection, if there is one. */
    void dismiss(CloseReason why) {
        end(why);
        leave(why.code());
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
            if (isNoted()) {
                world.notes().add(new SessionNote.Ended(name));
            }
        }
        world.publisher().dismiss(this); // must happen before another client may take the name
        world.leave(this, reason);
        // This call comes last, so that the world waits until the leave command is queued.
        pace.leave();
    }

    synchronized ServerMessage.@Nullable Ticket ticket() {
        String known = secret;
        return graceSeconds > 0 && known != null
                ? new ServerMessage.Ticket(known, graceSeconds, services.servers().get())
                : null;
    }

    Optional<ServerMessage.Rhythm> rhythm() {
        return pace.rhythm();
    }

    @Override
    public synchronized Optional<String> body() {
        return body;
    }

    /** Queues the result of a command. See {@link SessionOutput#offerResult}. */
    boolean offerResult(ServerMessage result, long frame) {
        return output.offerResult(result, frame);
    }

    /** Queues an encoded message. See {@link SessionOutput#offer(byte[])}. */
    boolean offer(byte[] line) {
        return output.offer(line);
    }

    void send(ServerMessage message) {
        output.send(message);
    }

    /** Ends the session's connection, if there is one. */
    void end(CloseReason why) {
        output.end(why);
    }
}
