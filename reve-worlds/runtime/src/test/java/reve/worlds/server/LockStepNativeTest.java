// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.agent.AgentServer;
import reve.core.agent.AgentServerConfig;
import reve.core.agent.port.Cameras;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreContents;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.io.UncheckedIOException;
import java.net.Socket;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicInteger;

/** The decisions of deadlines, in a recording. */
class LockStepNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "spring-orbit", "world.yaml");
    private static final int FRAMES = 60;
    private static final String SILENT =
            "{\"t\":\"hello\",\"protocol\":1,\"name\":\"silent\",\"time\":{\"mode\":\"lock-step\",\"deadline\":0.001,\"fallback\":{\"item\":\"blue\",\"action\":\"push\",\"arguments\":{\"impulse\":[0,0.1,0]}}}}\n"
                    + "{\"t\":\"ping\"}\n";

    @TempDir private Path folder;

    @Test
    void aRunInWhichAnAgentIsLateIsMadeAgainToTheBit() throws Exception {
        WorldDescription description = WorldFile.load(WORLD);
        Path log = folder.resolve("run.log");
        AtomicInteger late = new AtomicInteger();
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                AgentServer server =
                        AgentServer.start(
                                AgentServerConfig.onPort(0),
                                List.of(port(description, simulation)),
                                (source, problem) -> {});
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                });
                Socket agent =
                        new Socket(server.address().getAddress(), server.address().getPort())) {
            simulation.onPublish(
                    "late",
                    frame ->
                            late.addAndGet(
                                    (int)
                                            frame.world().events().stream()
                                                    .filter(event -> event.type().equals("late"))
                                                    .count()));
            agent.getOutputStream().write(SILENT.getBytes(StandardCharsets.UTF_8));
            assertThat(
                            new BufferedReader(
                                            new InputStreamReader(
                                                    agent.getInputStream(), StandardCharsets.UTF_8))
                                    .readLine())
                    .contains("pong");
            simulation.loop().run(FRAMES);
            hash = simulation.physics().stateHash();
        }
        assertThat(late).as("rounds that it was waited for").hasValue(3);
        assertMadeAgain(log, FRAMES, hash);
    }

    @Test
    void whatAnOperatorEditsWhileTheWorldWaitsIsInTheRecordingOfTheNextFrame() throws Exception {
        WorldDescription description = WorldFile.load(WORLD);
        Path log = folder.resolve("run.log");
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                AgentServer server =
                        AgentServer.start(
                                AgentServerConfig.onPort(0).withDeadline(Duration.ofSeconds(60)),
                                List.of(port(description, simulation)),
                                (source, problem) -> {});
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                });
                Line ada =
                        new Line(
                                server,
                                "{'t':'hello','protocol':1,'name':'ada','time':"
                                        + "{'mode':'lock-step','deadline':60}}");
                Line boss =
                        new Line(
                                server,
                                "{'t':'hello','protocol':1,'name':'boss','role':'control'}")) {
            boss.await("welcome");
            ada.say("{'t':'ping'}");
            ada.await("pong");
            var operator =
                    CompletableFuture.runAsync(
                            () -> {
                                for (int id = 1; id < FRAMES; id++) {
                                    ada.await("perception");
                                    boss.say(
                                            "{'t':'edit','id':"
                                                    + id
                                                    + ",'item':'blue','property':"
                                                    + "'physics.velocity','value':[0,"
                                                    + id
                                                    + ",0]}");
                                    assertThat(boss.await("result"))
                                            .contains("\"accepted\":true")
                                            .contains("\"frame\":" + (id + 1));
                                    ada.say("{'t':'ready'}");
                                }
                            });
            simulation.loop().run(FRAMES);
            operator.get(60, TimeUnit.SECONDS);
            hash = simulation.physics().stateHash();
        }
        assertMadeAgain(log, FRAMES, hash);
    }

    @Test
    void whatWasEditedAfterTheLastFrameIsKeptByARegularEnd() throws Exception {
        WorldDescription description = WorldFile.load(WORLD);
        Path file = folder.resolve("world.db");
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                SqliteStore store =
                        new SqliteStore(StoreContents.read(file), SqliteStore.Durability.NORMAL);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(1000, true),
                                store,
                                problem -> {
                                    throw new AssertionError(problem);
                                })) {
            simulation.loop().run(0);
            simulation.world().find("blue").orElseThrow().physics().set("velocity", 0, 7, 0);
        }
        StoreContents contents = StoreContents.read(file);
        assertThat(contents.problems()).isEmpty();
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST)) {
            for (JournalRecord record : contents.records()) {
                assertThat(replay.take(record)).isTrue();
            }
            try (Simulation again = replay.release()) {
                assertThat(again.world().find("blue").orElseThrow().physics().vector("velocity"))
                        .containsExactly(0, 7, 0);
            }
        }
    }

    private static void assertMadeAgain(Path log, long frames, long hash) throws Exception {
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // the list stays open for further records
            }
            assertThat(replay.divergence()).isEmpty();
            try (Simulation again = replay.release()) {
                assertThat(again.loop().frame()).isEqualTo(frames);
                assertThat(again.physics().stateHash()).isEqualTo(hash);
            }
        }
    }

    private static WorldPort port(WorldDescription description, Simulation simulation) {
        return new WorldPort(
                description.name(),
                description.timing().framesPerSecond(),
                description.agents(),
                simulation.bus(),
                simulation.commands(),
                simulation.snapshots(),
                simulation.loop(),
                WorldControl.none(),
                Cameras.none());
    }

    /** One client's connection. */
    private static final class Line implements AutoCloseable {
        private final Socket socket;
        private final BufferedReader in;

        Line(AgentServer server, String hello) throws IOException {
            socket = new Socket(server.address().getAddress(), server.address().getPort());
            in =
                    new BufferedReader(
                            new InputStreamReader(socket.getInputStream(), StandardCharsets.UTF_8));
            say(hello);
        }

        void say(String line) {
            try {
                socket.getOutputStream()
                        .write((line.replace('\'', '"') + "\n").getBytes(StandardCharsets.UTF_8));
            } catch (IOException e) {
                throw new UncheckedIOException(e);
            }
        }

        /** Returns the next message of that type. */
        String await(String type) {
            try {
                String line = in.readLine();
                while (!line.contains("\"t\":\"" + type + "\"")) {
                    line = in.readLine();
                }
                return line;
            } catch (IOException e) {
                throw new UncheckedIOException(e);
            }
        }

        @Override
        public void close() throws IOException {
            socket.close();
        }
    }
}
