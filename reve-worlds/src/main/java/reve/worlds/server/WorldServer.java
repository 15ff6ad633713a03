package reve.worlds.server;

import java.io.IOException;
import java.nio.file.Path;
import java.util.LinkedHashMap;
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

/**
 * A running world that agents join over TCP and law libraries are dropped into. Made, started, run
 * and closed by one thread, which owns the world; {@link #stop} is for any thread.
 */
public final class WorldServer implements AutoCloseable {
    private final Closing closing = new Closing();
    private final Simulation simulation;
    private final ServerEvents events;
    private final Optional<Path> lawsFolder;
    private final AgentServer agents;
    private final @Nullable LawFolder laws;

    /**
     * Builds the world, loads its laws, and begins to listen.
     *
     * @param lawsFolder watched for law libraries, if given
     * @param pictures closed by the server
     * @throws IOException if the port cannot be bound
     * @throws reve.pe.PhysicsException if a law of the world file does not load
     */
    public WorldServer(WorldDescription description, Pacing pacing, AgentServerConfig config,
            Optional<Path> lawsFolder, Pictures pictures, ServerEvents events) throws IOException {
        this.events = events;
        this.lawsFolder = lawsFolder;
        try {
            simulation = closing.add(new Simulation(description, pacing));
            closing.add(pictures);
            laws = lawsFolder.map(folder -> closing.add(new LawFolder(folder, simulation.engine(),
                    simulation.physics().laws(), simulation.commands()))).orElse(null);
            pictures.subscribeTo(simulation, events);
            simulation.onPublish("server events", this::tellEvents);
            agents = closing.add(AgentServer.start(config, new WorldPort(description.name(),
                    description.timing().framesPerSecond(), description.agents(), simulation.bus(),
                    simulation.commands(), simulation.snapshots(), simulation.loop(),
                    new ServerControl(simulation, pictures))));
        } catch (IOException | RuntimeException refused) {
            closing.closeAfter(refused);
            throw refused;
        }
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
        fields.put("agents", "127.0.0.1:" + port());
        fields.put("agentPort", port());
        AgentPolicy policy = simulation.description().agents();
        if (policy.bodies().isEmpty() && policy.template().isEmpty()) {
            fields.put("note", "the world file grants agents no body, so none can join");
        }
        lawsFolder.ifPresent(folder -> fields.put("laws", folder.toString()));
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
