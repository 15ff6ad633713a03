// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.SessionNotes;
import reve.core.agent.port.WorldPort;
import reve.core.file.AgentPolicy;
import reve.core.file.Problem;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.plugin.PluginInfo;
import reve.core.plugin.Plugins;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawFolder;
import reve.worlds.Product;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.Recording;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.WorldHeader;
import reve.worlds.render.Renderer;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.function.Supplier;

/**
 * One world of a server, with its journals and its watched folders of laws. The calling thread owns
 * the world during a call; {@link #stop} may be called on any thread.
 */
final class HostedWorld implements AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("reve.worlds");

    /**
     * Time for the last writes to the store after a signal. It leaves time for a report before the
     * process is ended after 10 s.
     */
    private static final Duration LAST_WRITES = Duration.ofSeconds(6);

    private final Closing closing = new Closing();
    private final WorldPlan plan;
    private final Optional<Path> lawsFolder;
    private final ServerEvents events;
    private final Optional<StoredWorld> stored;
    private final Simulation simulation;
    private final Shadows shadows;
    private final ServerControl control;
    private final BodyCameras cameras;
    private final List<LawFolder> laws = new ArrayList<>();
    private @Nullable Journal storeJournal;
    private @Nullable Journal recordingJournal;
    private Optional<String> unkept = Optional.empty();

    /** True after another server has taken the store. This was then reported. */
    private volatile boolean isLost;

    private Optional<Path> olderRecording = Optional.empty();

    /** Number of events of the frame in progress that were reported before PHYSICS. */
    private int reported;

    /**
     * Builds the world, loads its laws, and opens its journals.
     *
     * @param lawsFolder folder that is watched for law libraries, if present
     */
    HostedWorld(WorldPlan plan, Pacing pacing, Optional<Path> lawsFolder, ServerEvents events)
            throws IOException {
        this(plan, pacing, lawsFolder, events, Optional::empty);
    }

    /**
     * Builds the world of a server in a cluster, like {@link #HostedWorld(WorldPlan, Pacing,
     * Optional, ServerEvents)}.
     *
     * @param cluster returns the cluster, for operators
     */
    HostedWorld(
            WorldPlan plan,
            Pacing pacing,
            Optional<Path> lawsFolder,
            ServerEvents events,
            Supplier<Optional<ClusterPort>> cluster)
            throws IOException {
        this.plan = plan;
        this.lawsFolder = lawsFolder;
        this.events = events;
        try {
            stored = openStore(pacing);
            stored.ifPresent(world -> closing.add(world.store()));
            simulation =
                    closing.add(
                            stored.map(StoredWorld::simulation)
                                    .orElseGet(
                                            () ->
                                                    new Simulation(
                                                            plan.description(),
                                                            pacing,
                                                            plan.laws())));
            simulation.unloadExcluded();
            simulation.physics().enforceBudgets(true);
            simulation.measureProvidedSensors();
            simulation.usePluginListeners();
            closing.add(plan.pictures());
            shadows = closing.add(new Shadows(simulation, plan.swaps()));
            lawsFolder.ifPresent(folder -> laws.add(watch(LawFolder.ORIGIN, folder)));
            plan.laws()
                    .sandboxed()
                    .folder()
                    .ifPresent(folder -> laws.add(watch(LawFolder.UNTRUSTED_ORIGIN, folder)));
            control =
                    closing.add(
                            new ServerControl(
                                    simulation,
                                    plan.pictures(),
                                    plan.persistence().saves(),
                                    events,
                                    shadows,
                                    cluster));
            cameras =
                    closing.add(
                            new BodyCameras(
                                    simulation.snapshots(),
                                    new Renderer(
                                            Product.nativeFolder(), Renderer.DEFAULT_DEADLINE)));
            plan.pictures().subscribeTo(simulation, events);
            simulation.onPublish("server events", this::tellEvents);
            keepJournals(pacing == Pacing.FAST);
            stored.ifPresent(world -> world.store().whenLost(this::stopLost));
            shadows.start();
            closing.add(
                    simulation.bus().subscribe(FramePhase.ACT, "loaded laws", this::reportLoaded));
        } catch (IOException | RuntimeException refused) {
            closing.closeAfter(refused);
            throw refused;
        }
    }

    private LawFolder watch(String origin, Path folder) {
        return closing.add(
                new LawFolder(
                        origin,
                        folder,
                        simulation.engine(),
                        simulation.physics().laws(),
                        simulation.commands(),
                        LawParameters::inFile,
                        shadows));
    }

    private Optional<StoredWorld> openStore(Pacing pacing) throws IOException {
        Persistence persistence = plan.persistence();
        return persistence.store().isEmpty()
                ? Optional.empty()
                : Optional.of(
                        StoredWorld.open(
                                persistence.store().get(),
                                persistence.durability(),
                                plan.description(),
                                persistence.folder(),
                                pacing,
                                plan.laws(),
                                problem -> tellProblem("store", problem)));
    }

    /**
     * Opens the journals. Called as the last step, because journals must be the last listeners of
     * ACT, the phase for commands.
     */
    private void keepJournals(boolean waits) throws IOException {
        Persistence persistence = plan.persistence();
        Map<String, Long> members = stored.map(StoredWorld::members).orElse(Map.of());
        if (stored.isPresent()) {
            long frames =
                    Math.max(
                            1,
                            Math.round(
                                    persistence.imageSeconds()
                                            * plan.description().timing().framesPerSecond()));
            storeJournal =
                    closing.add(
                            simulation.journal(
                                    persistence.folder(),
                                    members,
                                    new Journal.Plan(
                                            frames,
                                            waits
                                                    || persistence.durability()
                                                            == SqliteStore.Durability.FULL),
                                    stored.get().store(),
                                    problem -> tellProblem("store", problem)));
        }
        if (persistence.recording().isPresent()) {
            Recording recording = new Recording(persistence.recording().get());
            olderRecording = recording.older();
            recordingJournal =
                    closing.add(
                            simulation.journal(
                                    persistence.folder(),
                                    members,
                                    new Journal.Plan(0, waits),
                                    recording,
                                    problem -> tellProblem("recording", problem)));
        }
    }

    /** Reports a failure that was not caused by a single law. For any thread. */
    void tellProblem(String source, String message) {
        LOG.warn("{}: {}: {}", name(), source, message);
        events.happened("fault", WorldServer.fault(source, message));
    }

    /** Stops the world, because another server has its store. For any thread. */
    private void stopLost(String message) {
        isLost = true;
        tellProblem("store", message);
        stop();
    }

    /** Returns the warnings about the world; none if it was restored from a store. */
    List<Problem> warnings() {
        return simulation.loop().frame() > 0 ? List.of() : simulation.warnings(true);
    }

    /** Returns whether the store, if there is one, accepts the frames of the world. Any thread. */
    boolean isKept() {
        Journal journal = storeJournal;
        return journal == null || !journal.isFailing();
    }

    Simulation simulation() {
        return simulation;
    }

    String name() {
        return plan.description().name();
    }

    /** Returns the header of the world's frames. */
    WorldHeader header() {
        return simulation.header(plan.persistence().folder());
    }

    /** Returns the interface through which an agent server uses the world. */
    WorldPort port() {
        return new WorldPort(
                name(),
                plan.description().timing().framesPerSecond(),
                plan.description().agents(),
                simulation.bus(),
                simulation.commands(),
                simulation.snapshots(),
                simulation.loop(),
                control,
                cameras,
                notes());
    }

    /** Returns the place for notes about sessions: the store, if other servers may continue it. */
    private SessionNotes notes() {
        Journal journal = storeJournal;
        return journal != null && journal.keepsSessions() ? journal::note : SessionNotes.NONE;
    }

    /** Returns the sessions of the previous server that continue with the world. */
    List<CarriedSession> sessions() {
        return stored.map(StoredWorld::sessions).orElse(List.of());
    }

    /** Stores sessions for the server that continues the world. Called after the last frame. */
    void handOver(List<CarriedSession> sessions) {
        if (stored.isEmpty() || sessions.isEmpty() || isLost) {
            return;
        }
        try {
            stored.get().store().handOver(simulation.loop().frame(), sessions);
        } catch (JournalSink.LostException lost) {
            // The listener of the store has reported it; the other server has the world.
        } catch (IOException e) {
            tellProblem("store", "the sessions of agents are lost: " + e.getMessage());
        }
    }

    /**
     * Records in the store that the world sleeps. Called after the last frame.
     *
     * @return false if it could not be recorded, which was then reported
     */
    boolean fallAsleep() {
        if (stored.isEmpty() || isLost) {
            return false;
        }
        try {
            stored.get().store().sleep();
            return true;
        } catch (JournalSink.LostException lost) {
            return false; // the listener of the store has reported it
        } catch (IOException e) {
            tellProblem("store", "the world does not sleep: " + e.getMessage());
            return false;
        }
    }

    /** Returns the fields of the event that reports that the world sleeps. */
    Map<String, Object> asleepFields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", name());
        fields.put("frame", simulation.loop().frame());
        stored.ifPresent(world -> world.epoch().ifPresent(epoch -> fields.put("epoch", epoch)));
        return fields;
    }

    /** Returns the interface through which a watchdog observes the world. */
    Watchdog.Subject watched() {
        return new Watchdog.Subject(name(), simulation.loop(), events);
    }

    /** Starts to watch the folders of laws, and reports that the world is ready. */
    void start(InetSocketAddress agents, Optional<String> page) {
        laws.forEach(LawFolder::start);
        stored.ifPresent(world -> announce(world.store(), agents));
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", name());
        fields.put("agents", agents.getHostString() + ":" + agents.getPort());
        fields.put("agentPort", agents.getPort());
        page.ifPresent(address -> fields.put("web", address));
        AgentPolicy policy = plan.description().agents();
        if (policy.bodies().isEmpty() && policy.template().isEmpty()) {
            fields.put("note", "the world file grants agents no body, so none can join");
        }
        lawsFolder.ifPresent(folder -> fields.put("laws", folder.toString()));
        List<PluginInfo> plugins = Plugins.current().infos();
        if (!plugins.isEmpty()) {
            fields.put("plugins", plugins.stream().map(PluginInfo::toString).toList());
        }
        Optional<Path> untrusted = plan.laws().sandboxed().folder();
        untrusted.ifPresent(folder -> fields.put("untrusted", folder.toString()));
        stored.ifPresent(
                world -> {
                    fields.put("store", plan.persistence().store().orElseThrow().toString());
                    world.epoch().ifPresent(epoch -> fields.put("epoch", epoch));
                    fields.put("frame", simulation.loop().frame());
                    fields.put("stateHash", String.format(Locale.ROOT, "%016x", world.stateHash()));
                });
        plan.persistence()
                .recording()
                .ifPresent(recording -> fields.put("recording", recording.file().toString()));
        olderRecording.ifPresent(file -> fields.put("olderRecording", file.toString()));
        List<Problem> warnings = warnings();
        if (!warnings.isEmpty()) {
            fields.put("warnings", warnings.stream().map(Problem::toString).toList());
        }
        fields.put("pid", ProcessHandle.current().pid());
        events.happened("ready", fields);
    }

    private void announce(JournalSink store, InetSocketAddress agents) {
        try {
            store.announce(agents.getHostString() + ":" + agents.getPort());
        } catch (JournalSink.LostException lost) {
            // The exception needs no further handling here, because the listener of the store stops
            // the world.
        } catch (IOException e) {
            tellProblem("store", e.getMessage());
        }
    }

    /** Returns whether another server has taken the world's store. For any thread. */
    boolean isLost() {
        return isLost;
    }

    /** Computes the planned frames, or fewer if {@link #stop} is called, and returns the report. */
    RunReport run() {
        long start = System.nanoTime();
        simulation.loop().run(plan.frames());
        return RunReport.of(simulation, (System.nanoTime() - start) * 1e-9);
    }

    /** Ends {@link #run} after the current frame. For any thread. */
    void stop() {
        simulation.loop().stop();
    }

    /** Limits the time of the last writes, because the process ends. For any thread. */
    void hurry() {
        stored.ifPresent(world -> world.store().hurry(LAST_WRITES));
    }

    /** Finishes pictures and journals, and frees all resources. Idempotent. */
    @Override
    public void close() {
        simulation.world().guard().claim();
        closing.close();
        if (unkept.isEmpty() && storeJournal != null) {
            unkept =
                    storeJournal
                            .shortfall()
                            .map(
                                    shortfall ->
                                            plan.persistence().store().orElseThrow()
                                                    + ": "
                                                    + shortfall);
            unkept.ifPresent(problem -> tellProblem("store", problem));
        }
    }

    /**
     * Returns a message about the data that the store lacks; empty if the store is complete. Valid
     * after close.
     */
    Optional<String> unkept() {
        return unkept;
    }

    /**
     * Returns a message about the frames that the recording lacks; empty if the recording is
     * complete. Valid after close.
     */
    Optional<String> gap() {
        return Optional.ofNullable(recordingJournal)
                .flatMap(Journal::gap)
                .map(gap -> plan.persistence().recording().orElseThrow().file() + ": " + gap);
    }

    /**
     * Reports the events of the frame so far if a law was loaded. This method runs after all
     * changes of ACT and before the law's first step. A later report would never appear if the law
     * did not return.
     */
    private void reportLoaded(FrameEvent frame) {
        List<WorldEvent> soFar = frame.world().events();
        for (WorldEvent event : soFar) {
            if (event.type().equals("law-loaded")) {
                report(frame, soFar);
                reported = soFar.size();
                return;
            }
        }
    }

    private void tellEvents(FrameEvent frame) {
        List<WorldEvent> all = frame.world().events();
        report(frame, all.subList(Math.min(reported, all.size()), all.size()));
        reported = 0;
    }

    private void report(FrameEvent frame, List<WorldEvent> raised) {
        for (WorldEvent event : raised) {
            if (!events.wants(event.type())) {
                continue;
            }
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("frame", event.frame());
            fields.put("time", frame.timeSeconds());
            event.fields().forEach(fields::putIfAbsent);
            events.happened(event.type(), fields);
        }
    }
}
