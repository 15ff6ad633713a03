// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.control.ControlDesk;
import reve.core.agent.control.Requester;
import reve.core.agent.net.Counters;
import reve.core.agent.port.FinishedCommand;
import reve.core.agent.port.SessionNote;
import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;

import java.util.Optional;

/**
 * The commands of one session. Each command is executed once. Its result is sent over the
 * connection that the session has when the result is available. For any thread. Guarded by the lock
 * of the session, so that no result is lost while a new connection resumes the session.
 */
final class SessionCommands implements Requester {

    private final Session session;
    private final ControlDesk desk;
    private final AgentLimits limits;
    private final Counters counters;
    private final CommandLog log = new CommandLog();

    /** Number of commands that have no result yet. */
    private int inFlight;

    SessionCommands(Session session, ControlDesk desk, AgentLimits limits, Counters counters) {
        this.session = session;
        this.desk = desk;
        this.limits = limits;
        this.counters = counters;
    }

    /** Returns the log of the commands. Guarded by the lock of the session. */
    CommandLog log() {
        return log;
    }

    @Override
    public String name() {
        return session.name();
    }

    @Override
    public boolean controls() {
        return session.role() == Role.CONTROL;
    }

    @Override
    public Optional<String> refusalOfLaw(String library) {
        return session.rights().refusalOfLaw(library);
    }

    @Override
    public Encoding encoding() {
        return session.encoding();
    }

    @Override
    public void endRound(ClientMessage.Ready ready) {
        session.endRound(ready);
    }

    @Override
    public void finish(ClientMessage.Request request, ServerMessage result, long frame) {
        if (request instanceof ClientMessage.Act) {
            (result instanceof ServerMessage.Accepted
                            ? counters.actsAccepted
                            : counters.actsRefused)
                    .increment();
        }
        boolean room;
        synchronized (session) {
            inFlight--;
            log.finish(request.id(), result);
            room = session.offerResult(result, frame);
        }
        if (!room) {
            session.end(CloseReason.cut("too-slow", "too many results wait to be read"));
        }
    }

    @Override
    public boolean notesResults() {
        return session.isNoted();
    }

    @Override
    public void note(ServerMessage result) {
        switch (result) {
            case ServerMessage.Accepted accepted ->
                    note(new FinishedCommand(accepted.id(), accepted.frame(), "", ""));
            case ServerMessage.Answer answer -> // its value is not stored
                    note(new FinishedCommand(answer.id(), answer.frame(), "", ""));
            case ServerMessage.Refused refused ->
                    note(new FinishedCommand(refused.id(), 0, refused.code(), refused.reason()));
            default ->
                    throw new IllegalArgumentException("found " + result + ", expected a result");
        }
    }

    private void note(FinishedCommand command) {
        session.world().notes().add(new SessionNote.Finished(name(), command));
    }

    /**
     * Executes a command, unless one with the same id was received before.
     *
     * @throws BadMessage if the client's rights do not include the command
     */
    void request(ClientMessage.Request request) throws BadMessage {
        Role needed = request instanceof ClientMessage.Act ? Role.AGENT : Role.CONTROL;
        boolean asks = request instanceof ClientMessage.Query && session.role() == Role.OBSERVER;
        if (session.role() != needed && !asks) {
            throw new BadMessage(
                    request.id(),
                    "not-permitted",
                    "this connection is "
                            + session
                            + ", and "
                            + request.type()
                            + " takes the role "
                            + needed.wireName(),
                    "say hello with \"role\":\"" + needed.wireName() + "\"");
        }
        Optional<String> refusal = session.rights().refusal(request);
        if (refusal.isPresent()) {
            throw new BadMessage(
                    request.id(),
                    "not-permitted",
                    "the token of " + name() + " does not permit " + request.type(),
                    refusal.get());
        }
        if (request instanceof ClientMessage.Act act && act.ready().isPresent()) {
            session.requireLockStep(act.id());
        }
        if (begin(request)) {
            desk.submit(this, request);
        }
    }

    /** Drops the queries that wait for an answer, after the session has lost its connection. */
    void forgetQueries() {
        desk.forget(this);
    }

    @Override
    public void refuse(ClientMessage.Request request, String code, String reason) {
        synchronized (session) {
            inFlight--;
            log.cancel(request.id());
        }
        if (request instanceof ClientMessage.Act) {
            counters.actsRefused.increment();
        }
        session.send(new ServerMessage.Refused(request.id(), code, reason));
    }

    @Override
    public boolean answer(ClientMessage.Request request, byte[] line) {
        if (line.length > limits.outboxBytes() / 2) {
            return false;
        }
        boolean room;
        synchronized (session) {
            inFlight--;
            log.cancel(request.id());
            room = session.offer(line);
        }
        if (!room) {
            session.end(CloseReason.cut("too-slow", "too many answers wait to be read"));
        }
        return true;
    }

    private boolean begin(ClientMessage.Request request) {
        CommandLog.Known known;
        boolean tooMany;
        synchronized (session) {
            known = log.look(request.id());
            tooMany = inFlight >= limits.actsInFlight();
            if (known instanceof CommandLog.Known.Fresh) {
                inFlight++;
                log.begin(request.id());
            }
        }
        switch (known) {
            case CommandLog.Known.Fresh fresh -> {
                if (tooMany) {
                    refuse(
                            request,
                            "too-many-acts",
                            limits.actsInFlight() + " commands wait for their result already");
                }
                return !tooMany;
            }
            case CommandLog.Known.Pending pending -> {}
            case CommandLog.Known.Done done -> session.send(done.result());
            case CommandLog.Known.Forgotten forgotten ->
                    session.send(
                            new ServerMessage.Refused(
                                    request.id(),
                                    "id-forgotten",
                                    "a command with this id may have been done long ago; "
                                            + "give new commands higher ids"));
        }
        return false;
    }
}
