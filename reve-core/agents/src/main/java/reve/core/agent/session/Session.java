// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.auth.AgentToken;
import reve.core.agent.auth.Attempts;
import reve.core.agent.auth.Rights;
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

import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.util.BitSet;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.BooleanSupplier;

/**
 * One client from its hello until it leaves, with its identity, requests and commands. After a
 * broken connection, the session continues for the time that the client requested. A new connection
 * that presents the session token resumes it. For any thread, unless stated otherwise.
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
    private final String secret;

    private final SessionSenses senses;
    private final SessionPace pace;
    private final SessionOutput output;

    /** Only the event loop's thread uses the quota. */
    private final Quota quota;

    private final CameraRequests cameraRequests;
    private final SessionCommands commands;
    private final PerceptionShares.Cost perceptionCost;

    // Guarded by this object's lock.
    private final Resumes resumes;
    private Optional<String> body = Optional.empty();
    private boolean welcomed;
    private boolean left;
    private long brokenNanos;

    /**
     * @param token token of the client, if the server uses tokens
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
        this.resumes = new Resumes(limits.resumes(), System.nanoTime());
        this.perceptionCost = world.publisher().shares().cost(token.map(AgentToken::name));
        this.cameraRequests =
                new CameraRequests(
                        world.cameras(), world.publisher(), services.log(), toString(), this::show);
        this.commands = new SessionCommands(this, world.desk(), limits, counters);
        this.senses = new SessionSenses(role);
        this.pace = new SessionPace(world.lockStep(), turn(connection, timeouts));
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

    private @Nullable Turn turn(Connection connection, AgentTimeouts timeouts) {
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
                        .of(
                                token.map(AgentToken::name),
                                Attempts.network(connection.address()),
                                System.nanoTime()));
    }

    private PerceptionRequests requestsOver(Connection connection) {
        var requests = new PerceptionRequests(connection.outbox(), counters.perceptions);
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
        return graceSeconds > 0
                && MessageDigest.isEqual(
                        secret.getBytes(StandardCharsets.US_ASCII),
                        claimed.getBytes(StandardCharsets.UTF_8));
    }

    /** Describes the client for reports: name, role, body, and how it perceives. */
    synchronized Map<String, Object> describe() {
        var fields = new LinkedHashMap<String, Object>();
        fields.put("name", name);
        fields.put("role", role.wireName());
        body.ifPresent(item -> fields.put("body", item));
        fields.put("connected", !output.isBroken());
        fields.put("limited", senses.areLimited());
        fields.put("lockStep", pace.isLockStep());
        return fields;
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
     * Handles the assignment of a body, possibly a different one than before. A refusal ends the
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
     * use this allowance.
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
    public Optional<BitSet> hear(
            WorldEvent event, EventSubjects subjects, Observatory observatory) {
        return senses.hear(event, subjects, observatory);
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
        senses.look(look, cameraRequests, this);
    }

    @Override
    public void request(ClientMessage.Request request) throws BadMessage {
        commands.request(request);
    }

    private void show(ServerMessage picture) {
        boolean room;
        synchronized (this) { // waits until no other connection is resuming the session
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
                    world.welcome(this, hello, world.publisher().published(), true), frameSeen);
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
     * Handles the end of a connection. If it was this session's current connection, the session
     * waits for a new one or ends.
     */
    @Override
    public void disconnected(Outbox outbox, CloseReason why) {
        synchronized (this) {
            if (left || !output.isSentBy(outbox)) {
                return;
            }
            output.breakOff();
            if (welcomed
                    && graceSeconds > 0
                    && RESUMABLE.contains(why.code())
                    && (token.isPresent() || services.kept().keep(this))) {
                brokenNanos = System.nanoTime();
                pace.breakOff(brokenNanos);
                return;
            }
        }
        leave(why.code());
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
        }
        world.publisher().dismiss(this); // must happen before another client may take the name
        world.leave(this, reason);
        pace.leave(); // last, so the world waits until the leave command is queued
    }

    synchronized ServerMessage.@Nullable Ticket ticket() {
        return graceSeconds > 0 ? new ServerMessage.Ticket(secret, graceSeconds) : null;
    }

    Optional<ServerMessage.Rhythm> rhythm() {
        return pace.rhythm();
    }

    @Override
    public synchronized Optional<String> body() {
        return body;
    }

    /** See {@link SessionOutput#offerResult}. */
    boolean offerResult(ServerMessage result, long frame) {
        return output.offerResult(result, frame);
    }

    /** See {@link SessionOutput#offer(byte[])}. */
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
