// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.world.ActionRefused;
import reve.core.world.World;

import java.util.Optional;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.atomic.AtomicLong;
import java.util.function.Consumer;

/**
 * Has commands done, each where it belongs: the world's queue, its frame loop, or the program. Any
 * thread.
 */
final class ControlDesk {

    private final WorldPort port;
    private final Publisher publisher;
    private final Members members;
    private final Images images;
    private final Studies studies;
    private final RateLimitedLog log;
    private final AtomicLong sequence = new AtomicLong();
    private final AtomicBoolean promptDue = new AtomicBoolean();

    /** World's thread. */
    private boolean executesPrompt;

    ControlDesk(WorldPort port, Publisher publisher, RateLimitedLog log) {
        this.port = port;
        this.publisher = publisher;
        this.members = new Members(port.agents(), port.framesPerSecond());
        this.images = new Images(port, members);
        this.studies = new Studies(port, members, log);
        this.log = log;
    }

    /**
     * The command that does this to the world.
     *
     * @param done told how it went, on the world's thread
     */
    AgentCommand command(AgentInput input, Consumer<Outcome> done) {
        return new AgentCommand(members, sequence.incrementAndGet(), input, done);
    }

    /** Has a command done and its result sent. */
    void submit(Session session, ClientMessage.Request request) {
        switch (request) {
            case ClientMessage.Act act -> {
                if (offer(
                        session,
                        act,
                        new AgentInput.Act(
                                session.name(), act.item(), act.action(), act.arguments()))) {
                    act.ready().ifPresent(session::endRound);
                }
            }
            case ClientMessage.Edit edit ->
                    offer(
                            session,
                            edit,
                            new AgentInput.Edit(
                                    session.name(), edit.item(), edit.property(), edit.value()));
            case ClientMessage.Pause pause -> accept(session, pause, port.loop().pause());
            case ClientMessage.Run run -> {
                accept(session, run, port.loop().frame());
                port.loop().resume();
                executePrompt();
            }
            case ClientMessage.Step step ->
                    between(
                            session,
                            step,
                            () -> {
                                long last = port.loop().resume(step.frames());
                                executePrompt();
                                return last;
                            });
            case ClientMessage.Snapshot snapshot ->
                    between(session, snapshot, () -> images.keep(snapshot.image()));
            case ClientMessage.Rewind rewind -> rewind(session, rewind);
            case ClientMessage.Save save -> studies.save(session, save);
            case ClientMessage.Fork fork -> studies.fork(session, fork);
            case ClientMessage.ShutDown shutDown -> {
                accept(session, shutDown, port.loop().frame());
                port.loop().stop();
            }
            case ClientMessage.LoadLaw load ->
                    change(
                            session,
                            load,
                            true,
                            () -> port.control().loadLaw(load.library(), load.parameters()));
            case ClientMessage.UnloadLaw unload ->
                    change(session, unload, true, () -> port.control().unloadLaw(unload.library()));
            case ClientMessage.Picture picture ->
                    change(session, picture, false, () -> port.control().picture());
        }
    }

    private static void accept(Session session, ClientMessage.Request request, long frame) {
        session.finish(request, new ServerMessage.Accepted(request.id(), frame), 0);
    }

    /**
     * An agent in lock-step was late, or came back. Loop's thread; done in the frame that begins
     * now, if that has room for it.
     */
    void lockStep(AgentInput news) {
        port.commands()
                .offer(
                        command(
                                news,
                                outcome -> {
                                    if (outcome instanceof Outcome.Failed failed) {
                                        publisher.withFrame(
                                                () ->
                                                        log.error(
                                                                "the fallback of agent "
                                                                        + news.agent()
                                                                        + " failed",
                                                                failed.cause()));
                                    }
                                }));
    }

    private boolean offer(Session session, ClientMessage.Request request, AgentInput input) {
        return offer(
                session, request, command(input, outcome -> deliver(session, request, outcome)));
    }

    private boolean offer(Session session, ClientMessage.Request request, Command command) {
        boolean taken = port.commands().offer(command);
        if (!taken) {
            session.refuse(
                    request, "world-busy", "the world has more to do than fits into a frame");
        } else if (command.isPrompt()) {
            executePrompt();
        }
        return taken;
    }

    /** Sends the result of a command with its frame or, if that is not being made, at once. */
    private void deliver(Session session, ClientMessage.Request request, Outcome outcome) {
        if (executesPrompt) {
            publisher.later(() -> answer(session, request, outcome));
        } else {
            publisher.withFrame(() -> answer(session, request, outcome));
        }
    }

    /** Has operators' commands executed before the next frame, which agents may hold up. */
    private void executePrompt() {
        if (!promptDue.getAndSet(true)) {
            port.loop()
                    .betweenFrames(
                            () -> {
                                promptDue.set(false);
                                executesPrompt = true;
                                try {
                                    port.loop().executePrompt(port.commands());
                                } finally {
                                    executesPrompt = false;
                                }
                            });
        }
    }

    // ---- between frames ----

    /** Something done between frames. */
    private interface Errand {
        /**
         * @return the frame that it took effect in
         */
        long run() throws ActionRefused;
    }

    /** The answer is on its way before the next frame is made. */
    private void between(Session session, ClientMessage.Request request, Errand errand) {
        port.loop()
                .betweenFrames(
                        () -> {
                            Outcome outcome = outcome(errand);
                            publisher.later(() -> answer(session, request, outcome));
                        });
    }

    private Outcome outcome(Errand errand) {
        try {
            return new Outcome.Done(errand.run());
        } catch (ActionRefused e) {
            return refused(e, port.loop().frame());
        } catch (RuntimeException e) {
            return new Outcome.Failed(port.loop().frame(), e);
        }
    }

    private void rewind(Session session, ClientMessage.Rewind rewind) {
        try {
            Optional<WorldControl.Image> beginning =
                    rewind.image().isPresent()
                            ? Optional.empty()
                            : Optional.of(port.control().beginning());
            between(
                    session,
                    rewind,
                    () -> {
                        Rewound rewound = images.rewind(session.name(), rewind.image(), beginning);
                        publisher.later(() -> publisher.tellRewound(rewound));
                        return rewound.frame();
                    });
        } catch (ActionRefused e) {
            answer(session, rewind, refused(e, 0));
        } catch (RuntimeException e) {
            answer(session, rewind, new Outcome.Failed(0, e));
        }
    }

    // ---- changes of the program's own ----

    private interface Preparation {
        WorldControl.Change prepare() throws ActionRefused;
    }

    /**
     * @param isPrompt false if it is about the next frame itself
     */
    private void change(
            Session session,
            ClientMessage.Request request,
            boolean isPrompt,
            Preparation preparation) {
        try {
            WorldControl.Change change = preparation.prepare();
            var command =
                    new ChangeCommand(
                            session.name(),
                            sequence.incrementAndGet(),
                            isPrompt,
                            change,
                            outcome -> deliver(session, request, outcome));
            if (!offer(session, request, command)) {
                change.drop();
            }
        } catch (ActionRefused e) {
            answer(session, request, refused(e, 0));
        } catch (RuntimeException e) {
            answer(session, request, new Outcome.Failed(0, e));
        }
    }

    private static Outcome refused(ActionRefused e, long frame) {
        return new Outcome.Refused(frame, e.code(), e.getMessage(), Optional.empty());
    }

    /** A prepared change on its way through the world's queue. */
    private record ChangeCommand(
            String origin,
            long sequence,
            boolean isPrompt,
            WorldControl.Change change,
            Consumer<Outcome> done)
            implements Command {

        @Override
        public void execute(World world, FrameEvent event) {
            try {
                change.make(world, event.frame());
                done.accept(new Outcome.Done(event.frame()));
            } catch (ActionRefused e) {
                done.accept(refused(e, event.frame()));
            } catch (RuntimeException e) {
                done.accept(new Outcome.Failed(event.frame(), e));
            }
        }
    }

    // ---- answers ----

    private void answer(Session session, ClientMessage.Request request, Outcome outcome) {
        switch (outcome) {
            case Outcome.Done done ->
                    session.finish(
                            request,
                            new ServerMessage.Accepted(request.id(), done.frame()),
                            done.frame());
            case Outcome.Refused no ->
                    session.finish(
                            request,
                            new ServerMessage.Refused(request.id(), no.code(), no.reason()),
                            no.frame());
            case Outcome.Failed failed -> {
                String what = describe(request);
                log.error(what + " failed", failed.cause());
                session.finish(
                        request,
                        new ServerMessage.Refused(
                                request.id(),
                                "action-failed",
                                what + " failed; the server's log says why"),
                        failed.frame());
            }
            case Outcome.Joined joined -> {}
            case Outcome.Absent absent -> {}
        }
    }

    private static String describe(ClientMessage.Request request) {
        return request instanceof ClientMessage.Act act
                ? "the action " + Text.quote(act.action()) + " of item " + Text.quote(act.item())
                : request.type();
    }
}
