package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.BufferedReader;
import java.io.InputStreamReader;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicInteger;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.Cameras;
import reve.core.agent.WorldControl;
import reve.core.agent.WorldPort;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.Journal;
import reve.worlds.journal.RunLog;

/** What deadlines decide, in a recording. */
class LockStepNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "spring-orbit", "world.yaml");
    private static final int FRAMES = 60;
    private static final String SILENT = "{\"t\":\"hello\",\"protocol\":1,\"name\":\"silent\","
            + "\"time\":{\"mode\":\"lock-step\",\"deadline\":0.001,\"fallback\":{\"item\":\"blue\","
            + "\"action\":\"push\",\"arguments\":{\"impulse\":[0,0.1,0]}}}}\n{\"t\":\"ping\"}\n";

    @TempDir
    private Path folder;

    @Test
    void aRunInWhichAnAgentIsLateIsMadeAgainToTheBit() throws Exception {
        WorldDescription description = WorldFile.load(WORLD);
        Path log = folder.resolve("run.log");
        AtomicInteger late = new AtomicInteger();
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                AgentServer server = AgentServer.start(AgentServerConfig.onPort(0),
                        List.of(port(description, simulation)), (source, problem) -> { });
                Journal _ = simulation.journal(WORLD.getParent(), Map.of(),
                        new Journal.Plan(0, true), RunLog.create(log), problem -> {
                            throw new AssertionError(problem);
                        });
                Socket agent = new Socket(server.address().getAddress(),
                        server.address().getPort())) {
            simulation.onPublish("late",
                    frame -> late.addAndGet((int) frame.world().events().stream()
                            .filter(event -> event.type().equals("late")).count()));
            agent.getOutputStream().write(SILENT.getBytes(StandardCharsets.UTF_8));
            assertThat(new BufferedReader(new InputStreamReader(agent.getInputStream(),
                    StandardCharsets.UTF_8)).readLine()).contains("pong");
            simulation.loop().run(FRAMES);
            hash = simulation.physics().stateHash();
        }
        assertThat(late).as("rounds that it was waited for").hasValue(3);
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // each record is made as it is read
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.loop().frame()).isEqualTo(FRAMES);
                assertThat(again.physics().stateHash()).isEqualTo(hash);
            }
        }
    }

    private static WorldPort port(WorldDescription description, Simulation simulation) {
        return new WorldPort(description.name(), description.timing().framesPerSecond(),
                description.agents(), simulation.bus(), simulation.commands(),
                simulation.snapshots(), simulation.loop(), WorldControl.none(), Cameras.none());
    }
}
