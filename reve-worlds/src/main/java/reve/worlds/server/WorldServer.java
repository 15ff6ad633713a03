package reve.worlds.server;

import java.io.IOException;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import org.jspecify.annotations.Nullable;
import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.WorldPort;
import reve.core.file.AgentPolicy;
import reve.core.file.WorldDescription;
import reve.core.frame.FrameEvent;
import reve.core.frame.Pacing;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawFolder;
import reve.worlds.journal.Journal;
import reve.worlds.journal.RunLog;

/**
 * A running world that agents join over TCP and law libraries are dropped into. Made, started, run
 * and closed by one thread, which owns the world; {@link #stop} is for any thread.
 */
public final class WorldServer implements AutoCloseable {
    private final Closing closing = new Closing();
    private final Simulation simulation;
    private final ServerEvents events;
    private final Optional<Path> lawsFolder;
    private final Persistence persistence;
    private final Optional<StoredWorld> stored;
    private final AgentServer agents;
    private final @Nullable LawFolder laws;

    /**
     * Builds the world, loads its laws, and begins to listen.
     *
     * @param lawsFolder watched for law libraries, if given
     * @param persistence where the world comes from, if it is stored, and what is kept of the run
     * @param pictures closed by the server
     * @throws IOException if the port cannot be bound, or a file not opened
     * @throws reve.core.store.CorruptException if the store is damaged, or no store of this world
     * @throws reve.pe.PhysicsException if a law of the world file does not load
     */
    public WorldServer(WorldDescription description, Pacing pacing, AgentServerConfig config,
            Optional<Path> lawsFolder, Persistence persistence, Pictures pictures,
            ServerEvents events) throws IOException {
        this.events = events;
        this.lawsFolder = lawsFolder;
        this.persistence = persistence;
        try {
            stored = openStore(description, pacing);
            stored.ifPresent(world -> closing.add(world.store()));
            simulation = closing.add(stored.map(StoredWorld::simulation)
                    .orElseGet(() -> new Simulation(description, pacing)));
            closing.add(pictures);
            laws = lawsFolder.map(folder -> closing.add(new LawFolder(folder, simulation.engine(),
                    simulation.physics().laws(), simulation.commands()))).orElse(null);
            pictures.subscribeTo(simulation, events);
            simulation.onPublish("server events", this::tellEvents);
            agents = closing.add(AgentServer.start(config, new WorldPort(description.name(),
                    description.timing().framesPerSecond(), description.agents(), simulation.bus(),
                    simulation.commands(), simulation.snapshots(), simulation.loop(),
                    closing.add(new ServerControl(simulation, pictures)))));
            keepJournals(pacing == Pacing.FAST);
        } catch (IOException | RuntimeException refused) {
            closing.closeAfter(refused);
            throw refused;
        }
    }

    private Optional<StoredWorld> openStore(WorldDescription description, Pacing pacing)
            throws IOException {
        return persistence.store().isEmpty() ? Optional.empty()
                : Optional.of(StoredWorld.open(persistence.store().get(), persistence.durability(),
                        description, pacing, problem -> tellProblem("store", problem)));
    }

    /** Last, so that they see what everybody else did in ACT. */
    private void keepJournals(boolean waits) throws IOException {
        if (stored.isPresent()) {
            long frames = Math.max(1, Math.round(persistence.imageSeconds()
                    * simulation.description().timing().framesPerSecond()));
            closing.add(simulation.journal(persistence.folder(), Map.of(),
                    new Journal.Plan(frames, waits), stored.get().store(),
                    problem -> tellProblem("store", problem)));
        }
        if (persistence.recording().isPresent()) {
            closing.add(simulation.journal(persistence.folder(), Map.of(),
                    new Journal.Plan(0, waits), RunLog.create(persistence.recording().get()),
                    problem -> tellProblem("recording", problem)));
        }
    }

    private void tellProblem(String source, String message) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("source", source);
        fields.put("message", message);
        events.happened("fault", fields);
    }

    /** The port that agents join at. */
    public int port() {
        return agents.address().getPort();
    }

    /** Begins to watch the laws folder, and says that the server is ready. */
    public void start() {
        if (laws != null) {
            laws.start();
        }
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("world", simulation.description().name());
        fields.put("agents", agents.address().getHostString() + ":" + port());
        fields.put("agentPort", port());
        AgentPolicy policy = simulation.description().agents();
        if (policy.bodies().isEmpty() && policy.template().isEmpty()) {
            fields.put("note", "the world file grants agents no body, so none can join");
        }
        lawsFolder.ifPresent(folder -> fields.put("laws", folder.toString()));
        stored.ifPresent(world -> {
            fields.put("store", persistence.store().orElseThrow().toString());
            fields.put("frame", simulation.loop().frame());
            fields.put("stateHash", String.format(Locale.ROOT, "%016x", world.stateHash()));
        });
        persistence.recording().ifPresent(file -> fields.put("recording", file.toString()));
        fields.put("pid", ProcessHandle.current().pid());
        events.happened("ready", fields);
    }

    /** Makes that many frames, fewer if {@link #stop} is called, and reports on them. */
    public ServerReport run(long frames) {
        long start = System.nanoTime();
        simulation.loop().run(frames);
        double wallSeconds = (System.nanoTime() - start) * 1e-9;
        return new ServerReport(RunReport.of(simulation, wallSeconds), agents.stats());
    }

    /** Ends {@link #run} after its frame. Any thread. */
    public void stop() {
        simulation.loop().stop();
    }

    /** Says goodbye to agents, finishes pictures, frees everything. May be called twice. */
    @Override
    public void close() {
        closing.close();
    }

    private void tellEvents(FrameEvent frame) {
        for (WorldEvent event : frame.world().events()) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("frame", event.frame());
            fields.put("time", frame.timeSeconds());
            event.fields().forEach(fields::putIfAbsent);
            events.happened(event.type(), fields);
        }
    }
}
