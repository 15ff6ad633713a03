// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.audit.AuditLog;
import reve.core.agent.embodiment.AgentCommand;
import reve.core.agent.embodiment.AgentInput;
import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.embodiment.Heard;
import reve.core.agent.embodiment.Outcome;
import reve.core.agent.embodiment.Rewound;
import reve.core.agent.net.RateLimitedLog;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;
import reve.core.agent.publish.Publisher;
import reve.core.frame.Command;
import reve.core.frame.FrameEvent;
import reve.core.frame.Pacing;
import reve.core.world.ActionRefused;
import reve.core.world.World;
import reve.core.world.WorldSnapshot;

import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.atomic.AtomicLong;
import java.util.function.BooleanSupplier;
import java.util.function.Consumer;

/**
 * Dispatcher of clients' commands for one world. It passes each command to the world's command
 * queue, to its frame loop, or to the program that runs the world. For any thread.
 */
public final class ControlDesk {

    private final WorldPort port;
    private final Publisher publisher;
    private final Embodiment embodiment;
    private final Images images;
    private final ItemPace pace;
    private final WorldEdits edits;
    private final ForkAndSave forkAndSave;
    private final Reports reports;
    private final Clients clients;
    private final RateLimitedLog log;
    private final AtomicLong sequence = new AtomicLong();
    private final AtomicBoolean promptDue = new AtomicBoolean();

    /**
     * True while the world's thread executes prompt commands, that is, commands that do not wait
     * for agents in lock-step. For the world's thread only.
     */
    private boolean executesPrompt;

    /**
     * Creates a desk for the commands to one world.
     *
     * @param clients the world's clients
     * @param audit the record of all messages to clients, for reports
     * @param isShared returns whether the server has further worlds
     */
    public ControlDesk(
            WorldPort port,
            Publisher publisher,
            RateLimitedLog log,
            Clients clients,
            Optional<AuditLog> audit,
            BooleanSupplier isShared) {
        this.port = port;
        this.publisher = publisher;
        this.embodiment = new Embodiment(port.agents(), port.framesPerSecond());
        this.images = new Images(port, embodiment);
        this.pace = new ItemPace(isShared);
        this.edits = new WorldEdits(port, embodiment, pace);
        this.forkAndSave = new ForkAndSave(port, embodiment, log);
        this.reports = new Reports(port, publisher, images, log, clients, audit);
        this.clients = clients;
        this.log = log;
    }

    /** Returns the agents of the world and their bodies. For the world's thread only. */
    public Embodiment embodiment() {
        return embodiment;
    }

    /**
     * Returns the command that applies an input to the world.
     *
     * @param done receives the outcome on the world's thread
     */
    public AgentCommand command(AgentInput input, Consumer<Outcome> done) {
        return new AgentCommand(embodiment, sequence.incrementAndGet(), input, done);
    }

    /**
     * Returns the utterances that agents have heard in the frame that is being made, one entry per
     * hearer. For the world's thread only.
     */
    public List<Heard> takeHeard() {
        return embodiment.takeHeard();
    }

    /**
     * Answers waiting queries if the reports so far have not used up their share of time. Called
     * periodically.
     */
    public void proceed() {
        reports.proceed();
    }

    /** Drops the waiting queries of a client that has no connection any more. */
    public void forget(Requester requester) {
        reports.forget(requester);
    }

    /** Submits a command; its result is sent to the requester. */
    public void submit(Requester requester, ClientMessage.Request request) {
        switch (request) {
            case ClientMessage.Act act -> {
                if (offer(requester, act, new AgentInput.Act(requester.name(), act.requested()))) {
                    act.ready().ifPresent(requester::endRound);
                }
            }
            case ClientMessage.Edit edit -> edit(requester, edit);
            case ClientMessage.WorldChange change ->
                    change(requester, change, true, () -> edits.prepare(change));
            case ClientMessage.Pause pause -> accept(requester, pause, port.loop().pause());
            case ClientMessage.Run run -> {
                accept(requester, run, port.loop().frame());
                port.loop().resume();
                executePrompt();
            }
            case ClientMessage.Step step ->
                    between(
                            requester,
                            step,
                            () -> {
                                long last = port.loop().resume(step.frames());
                                executePrompt();
                                return last;
                            });
            case ClientMessage.Snapshot snapshot ->
                    between(requester, snapshot, () -> images.keep(snapshot.image()));
            case ClientMessage.Rewind rewind -> rewind(requester, rewind);
            case ClientMessage.Save save -> forkAndSave.save(requester, save);
            case ClientMessage.Fork fork -> fork(requester, fork);
            case ClientMessage.Ask ask -> ask(requester, ask);
            case ClientMessage.MoveWorld move ->
                    order(requester, move, cluster -> cluster.move(move.world(), move.node()));
            case ClientMessage.DrainNode drain ->
                    order(
                            requester,
                            drain,
                            cluster -> cluster.drain(drain.node(), drain.drained()));
            case ClientMessage.AddWorld add ->
                    order(requester, add, cluster -> cluster.add(add.text(), add.asleep()));
            case ClientMessage.Release release ->
                    change(
                            requester,
                            release,
                            true,
                            () -> port.control().release(release.library()));
            case ClientMessage.ShutDown shutDown -> {
                accept(requester, shutDown, port.loop().frame());
                port.loop().stop();
            }
            case ClientMessage.LoadLaw load ->
                    change(
                            requester,
                            load,
                            true,
                            () ->
                                    load.text().isPresent()
                                            ? port.control()
                                                    .loadText(
                                                            load.library(),
                                                            load.text().get(),
                                                            load.parameters(),
                                                            load.swap())
                                            : loadLaw(requester, load));
            case ClientMessage.UnloadLaw unload ->
                    change(
                            requester,
                            unload,
                            true,
                            () -> port.control().unloadLaw(unload.library()));
            case ClientMessage.SetLaw set ->
                    change(
                            requester,
                            set,
                            true,
                            () ->
                                    port.control()
                                            .setLaw(set.library(), set.parameters(), set.swap()));
            case ClientMessage.SetBudget set ->
                    change(
                            requester,
                            set,
                            true,
                            () -> port.control().setBudget(set.library(), set.budget()));
            case ClientMessage.Picture picture ->
                    change(requester, picture, false, () -> port.control().picture());
            case ClientMessage.Speed speed -> {
                if (port.loop().pacing() == Pacing.FAST) {
                    answer(
                            requester,
                            speed,
                            new Outcome.Refused(
                                    0,
                                    "unsupported",
                                    "this world makes frames as fast as possible (--fast)",
                                    Optional.empty()));
                } else {
                    port.loop().setSpeed(speed.factor());
                    accept(requester, speed, port.loop().frame());
                }
            }
            case ClientMessage.State state -> reports.state(requester, state);
            case ClientMessage.Inspect inspect -> reports.item(requester, inspect);
            case ClientMessage.Laws laws -> reports.laws(requester, laws);
            case ClientMessage.Ledger ledger -> reports.ledger(requester, ledger);
            case ClientMessage.Search search -> reports.search(requester, search);
            case ClientMessage.Perceived perceived -> reports.perceived(requester, perceived);
            case ClientMessage.Audit audit -> reports.audit(requester, audit);
        }
    }

    /** Hides why a library cannot be opened from a client whose token does not permit it. */
    private WorldControl.Change loadLaw(Requester requester, ClientMessage.LoadLaw load)
            throws ActionRefused {
        try {
            return port.control().loadLaw(load.library(), load.parameters(), load.swap());
        } catch (ActionRefused refused) {
            if (requester.refusalOfLaw(load.library()).isEmpty()) {
                throw refused;
            }
            throw new ActionRefused(
                    refused.code(),
                    "the library \"" + load.library() + "\" is refused; the server's log says why",
                    refused);
        }
    }

    private static void accept(Requester requester, ClientMessage.Request request, long frame) {
        requester.finish(request, new ServerMessage.Accepted(request.id(), frame), 0);
    }

    /**
     * Queues an input that reports a late or returned agent in lock-step. The input is dropped if
     * the queue for the next frame is full. Called on the thread of the frame loop.
     */
    public void lockStep(AgentInput news) {
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

    private void edit(Requester requester, ClientMessage.Edit edit) {
        try {
            if (edit.property().startsWith("semantic.")) { // the only values without a fixed size
                HeapRoom.OF_PROCESS.require();
            }
        } catch (ActionRefused full) {
            requester.refuse(edit, full.code(), String.valueOf(full.getMessage()));
            return;
        }
        offer(
                requester,
                edit,
                new AgentInput.Edit(requester.name(), edit.item(), edit.property(), edit.value()));
    }

    private boolean offer(Requester requester, ClientMessage.Request request, AgentInput input) {
        return offer(
                requester,
                request,
                command(input, outcome -> deliver(requester, request, outcome)));
    }

    private boolean offer(Requester requester, ClientMessage.Request request, Command command) {
        boolean taken = port.commands().offer(command);
        if (!taken) {
            requester.refuse(
                    request, "world-busy", "the world has more to do than fits into a frame");
        } else if (command.isPrompt()) {
            executePrompt();
        }
        return taken;
    }

    /**
     * Sends the result of a command. Normally the result is sent together with the frame that
     * executed the command. The result of a prompt command that ran between frames is sent at once.
     */
    private void deliver(Requester requester, ClientMessage.Request request, Outcome outcome) {
        if (requester.notesResults()) {
            resultOf(request, outcome).ifPresent(requester::note);
        }
        if (executesPrompt) {
            if (outcome instanceof Outcome.Done done) {
                reports.changed(done.frame());
            }
            publisher.later(() -> answer(requester, request, outcome));
        } else {
            publisher.withFrame(() -> answer(requester, request, outcome));
        }
    }

    /**
     * Executes operators' commands between frames. They do not wait for the next frame, because
     * agents in lock-step may delay it.
     */
    private void executePrompt() {
        if (!promptDue.getAndSet(true)) {
            port.loop()
                    .betweenFrames(
                            () -> {
                                promptDue.set(false);
                                executesPrompt = true;
                                boolean more;
                                try {
                                    more = port.loop().executePrompt(port.commands());
                                } finally {
                                    executesPrompt = false;
                                }
                                if (more) {
                                    executePrompt();
                                }
                            });
        }
    }

    /** The operation of a command that is executed between two frames. */
    private interface Errand {
        /**
         * Executes the command.
         *
         * @return number of the frame in which the command takes effect
         */
        long run() throws ActionRefused;
    }

    /**
     * Runs an operation between two frames, and queues its answer before the next frame is made.
     */
    private void between(Requester requester, ClientMessage.Request request, Errand errand) {
        port.loop()
                .betweenFrames(
                        () -> {
                            Outcome outcome = outcome(errand);
                            publisher.later(() -> answer(requester, request, outcome));
                        });
    }

    private void fork(Requester requester, ClientMessage.Fork fork) {
        try {
            forkAndSave.fork(requester, fork, edits.prepare(fork));
        } catch (ActionRefused e) {
            answer(requester, fork, refused(e, 0));
        }
    }

    /** Answers a question about the world between two frames, even if the world is paused. */
    private void ask(Requester requester, ClientMessage.Ask ask) {
        port.loop()
                .betweenFrames(
                        () -> {
                            long frame = port.loop().frame();
                            try {
                                Object value = port.control().answer(ask.what(), ask.arguments());
                                byte[] line =
                                        new ServerMessage.Answer(ask.id(), frame, value)
                                                .in(requester.encoding());
                                publisher.later(() -> give(requester, ask, line));
                            } catch (ActionRefused e) {
                                publisher.later(() -> answer(requester, ask, refused(e, frame)));
                            } catch (RuntimeException e) {
                                publisher.later(
                                        () -> answer(requester, ask, new Outcome.Failed(frame, e)));
                            }
                        });
    }

    /** An order to the cluster of the server. */
    private interface Order {
        Map<String, Object> give(ClusterPort cluster) throws ActionRefused;
    }

    /** Gives an order to the cluster of the server. The world does not wait for it. */
    private void order(Requester requester, ClientMessage.Order request, Order order) {
        try {
            ClusterPort cluster =
                    port.control()
                            .cluster()
                            .orElseThrow(
                                    () ->
                                            new ActionRefused(
                                                    "unsupported",
                                                    "this server belongs to no cluster"));
            Object value = order.give(cluster);
            requester.finish(
                    request, new ServerMessage.Answer(request.id(), port.loop().frame(), value), 0);
        } catch (ActionRefused e) {
            answer(requester, request, refused(e, 0));
        } catch (RuntimeException e) {
            answer(requester, request, new Outcome.Failed(0, e));
        }
    }

    private static void give(Requester requester, ClientMessage.Ask ask, byte[] line) {
        if (!requester.answer(ask, line)) {
            requester.refuse(
                    ask,
                    "too-large",
                    "the answer has "
                            + line.length
                            + " bytes, which is more than is sent at once; ask for less");
        }
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

    private void rewind(Requester requester, ClientMessage.Rewind rewind) {
        try {
            pace.take(items());
            Optional<WorldControl.Image> beginning =
                    rewind.image().isPresent()
                            ? Optional.empty()
                            : Optional.of(port.control().beginning());
            between(
                    requester,
                    rewind,
                    () -> {
                        Rewound rewound =
                                images.rewind(requester.name(), rewind.image(), beginning);
                        clients.noteBodies();
                        publisher.later(() -> publisher.tellRewound(rewound));
                        return rewound.frame();
                    });
        } catch (ActionRefused e) {
            answer(requester, rewind, refused(e, 0));
        } catch (RuntimeException e) {
            answer(requester, rewind, new Outcome.Failed(0, e));
        }
    }

    /** Returns the number of items of the last frame. */
    private int items() {
        Optional<WorldSnapshot> latest = port.snapshots().acquireLatest();
        try {
            return latest.map(snapshot -> snapshot.symbols().size()).orElse(0);
        } finally {
            latest.ifPresent(WorldSnapshot::close);
        }
    }

    private interface Preparation {
        WorldControl.Change prepare() throws ActionRefused;
    }

    /**
     * Submits a prepared change of the world.
     *
     * @param isPrompt true if the change may be made before the next frame, false if it must be
     *     part of the next frame
     */
    private void change(
            Requester requester,
            ClientMessage.Request request,
            boolean isPrompt,
            Preparation preparation) {
        try {
            WorldControl.Change change = preparation.prepare();
            Optional<String> refusal = change.library().flatMap(requester::refusalOfLaw);
            if (refusal.isPresent()) {
                change.drop();
                throw new ActionRefused(
                        "not-permitted",
                        "the token of "
                                + requester.name()
                                + " does not permit this: "
                                + refusal.get());
            }
            var command =
                    new ChangeCommand(
                            requester.name(),
                            sequence.incrementAndGet(),
                            isPrompt,
                            change,
                            outcome -> deliver(requester, request, outcome));
            if (!offer(requester, request, command)) {
                change.drop();
            }
        } catch (ActionRefused e) {
            answer(requester, request, refused(e, 0));
        } catch (RuntimeException e) {
            answer(requester, request, new Outcome.Failed(0, e));
        }
    }

    private static Outcome refused(ActionRefused e, long frame) {
        return new Outcome.Refused(frame, e.code(), e.getMessage(), Optional.empty());
    }

    /** A command for the world's queue that makes a prepared change. */
    private record ChangeCommand(
            String origin,
            long sequence,
            boolean isPrompt,
            WorldControl.Change change,
            Consumer<Outcome> done)
            implements Command {

        @Override
        public boolean isCostly() {
            return true;
        }

        @Override
        public void execute(World world, FrameEvent event) {
            try {
                change.make(world, event.frame());
                done.accept(new Outcome.Done(event.frame(), change.value()));
            } catch (ActionRefused e) {
                done.accept(refused(e, event.frame()));
            } catch (RuntimeException e) {
                done.accept(new Outcome.Failed(event.frame(), e));
            }
        }
    }

    private void answer(Requester requester, ClientMessage.Request request, Outcome outcome) {
        if (outcome instanceof Outcome.Failed failed) {
            log.error(describe(request) + " failed", failed.cause());
        }
        long frame =
                switch (outcome) {
                    case Outcome.Done done -> done.frame();
                    case Outcome.Refused refused -> refused.frame();
                    case Outcome.Failed failed -> failed.frame();
                    case Outcome.Joined _, Outcome.Absent _ -> 0;
                };
        resultOf(request, outcome).ifPresent(result -> requester.finish(request, result, frame));
    }

    /** Returns the result that a client receives for a command; empty if it receives none. */
    private static Optional<ServerMessage> resultOf(
            ClientMessage.Request request, Outcome outcome) {
        return switch (outcome) {
            case Outcome.Done done ->
                    Optional.of(
                            done.value().isPresent()
                                    ? new ServerMessage.Answer(
                                            request.id(), done.frame(), done.value().get())
                                    : new ServerMessage.Accepted(request.id(), done.frame()));
            case Outcome.Refused refused ->
                    Optional.of(
                            new ServerMessage.Refused(
                                    request.id(), refused.code(), refused.reason()));
            case Outcome.Failed _ ->
                    Optional.of(
                            new ServerMessage.Refused(
                                    request.id(),
                                    "action-failed",
                                    describe(request) + " failed; the server's log says why"));
            case Outcome.Joined _, Outcome.Absent _ -> Optional.empty();
        };
    }

    private static String describe(ClientMessage.Request request) {
        return request instanceof ClientMessage.Act act
                ? "the action "
                        + Text.quote(act.requested().action())
                        + " of item "
                        + Text.quote(act.requested().item().orElseThrow())
                : request.type();
    }
}
