// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.AgentException;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.io.InputStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;

/** The reports of a server and its end, if worlds stand still or the memory is full. */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class StandstillIT {
    private static final String WORLD =
            """
            reve: 1
            name: stones
            laws: [newton_motion]
            agents: {body: {physical: {location: [0, 0, 0]}}}
            items:
              - name: stone
                physical: {location: [1, 0, 0]}
                physics: {mass: 1 kg, velocity: [1, 0, 0]}
                access: {hang: {java: example.hang}, hoard: {java: example.hoard}}
            """;
    private static final int STALLED = 6;
    private static final int OUT_OF_MEMORY = 128 + 9;

    @TempDir private Path folder;

    private Shell shell;

    @BeforeEach
    void makeActions() throws Exception {
        shell = new Shell(folder);
        for (String file : List.of("Hang.java", "Hoard.java", "spinning.cpp")) {
            try (InputStream text = StandstillIT.class.getResourceAsStream(file)) {
                Files.write(folder.resolve(file), text.readAllBytes());
            }
        }
        Path services = Files.createDirectories(folder.resolve("jar/META-INF/services"));
        Files.writeString(
                services.resolve("reve.core.access.ActionProvider"),
                "example.Hang\nexample.Hoard\n");
        Files.writeString(folder.resolve("stones.yaml"), WORLD);
        shell.run(
                System.getProperty("java.home")
                        + "/bin/javac -proc:none -cp"
                        + " \"$REVE/build/stage/lib/reve-core-files.jar\" -d jar Hang.java Hoard.java");
    }

    /** A server whose actions in Java are those of this test. */
    private Server serve(String environment, String options) throws IOException {
        return shell.serve(
                environment
                        + " REVE_CLASSPATH=jar exec \"$REVE/reve\" serve"
                        + " stones.yaml "
                        + options);
    }

    /** Sends an act that may never be answered. */
    private static Thread act(String port, String action) {
        return Thread.ofVirtual()
                .start(
                        () -> {
                            try (AgentClient agent = Agents.join(Integer.parseInt(port), "ada")) {
                                agent.act("stone", action, Map.of());
                            } catch (AgentException | IOException gone) {
                                // the server ended meanwhile
                            }
                        });
    }

    @Test
    void anActionThatHangsIsReportedWithPhaseAndPlaceUntilFramesAreMadeAgain() throws Exception {
        Path hang = Files.createFile(folder.resolve("hang"));
        try (Server server = serve("", "--watchdog 0.5")) {
            Thread agent = act(server.port(), "hang");

            JsonNode first = server.events().await("stalled", StandstillIT::isOfAct);
            assertThat(first.path("world").asString()).isEqualTo("stones");
            assertThat(first.path("frame").asLong()).isPositive();
            assertThat(first.path("seconds").asDouble()).isBetween(0.5, 10.0);
            assertThat(first.path("activity").asString()).contains("action example.hang of stone");
            assertThat(first.path("stack").toString()).contains("example.Hang.decide(Hang.java:");
            JsonNode second =
                    server.events().await("stalled", event -> event != first && isOfAct(event));
            assertThat(second.path("seconds").asDouble() / first.path("seconds").asDouble())
                    .as("reported again when it has lasted twice as long")
                    .isBetween(1.4, 8.0);

            Files.delete(hang);
            server.events()
                    .await(
                            "recovered",
                            event -> event.path("frame").asLong() >= first.path("frame").asLong());
            agent.join();
            server.process().toHandle().destroy();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }
        assertThat(shell.messages())
                .contains(
                        "ERROR watchdog: the world stones stands still",
                        "WARN  watchdog: the world stones makes frames again");
    }

    private static boolean isOfAct(JsonNode stalled) {
        return stalled.path("phase").asString().equals("ACT");
    }

    @Test
    void aPausedWorldDoesNotStandStill() throws Exception {
        try (Server server = serve("", "--watchdog 10")) {
            String control = "\"$REVE/reve\" control --port " + server.port();
            // No frame takes as long as the limit, and both pauses are longer.
            String wait = "\nsleep 15\n";
            shell.run(
                    control
                            + " pause"
                            + wait
                            + control
                            + " step frames=1"
                            + wait
                            + control
                            + " run");
            server.process().toHandle().destroy();
            assertThat(server.events().untilEnd())
                    .extracting(e -> e.path("event").asString())
                    .contains("end")
                    .doesNotContain("stalled");
        }
    }

    @Test
    void aLawOfThisProcessThatNeverReturnsIsNamedAndEndsTheServerByRule() throws Exception {
        shell.run(
                "mkdir laws\ng++ -std=c++20 -shared -fPIC -O1 -fvisibility=hidden"
                        + " -I\"$REVE/vesper-native/include\" spinning.cpp -o spinning.so");
        long frame;
        String options =
                "--engine in-process --watchdog 20 --stalled exit --laws laws --store my.db";
        try (Server server = serve("", options)) {
            server.port();
            Files.move(folder.resolve("spinning.so"), folder.resolve("laws/spinning.so"));
            JsonNode stalled = server.events().await("stalled", event -> true);
            frame = stalled.path("frame").asLong();
            assertThat(stalled.path("phase").asString()).isEqualTo("PHYSICS");
            assertThat(stalled.path("activity").asString())
                    .contains("native code (advance)", "newton_motion", "spinning");
            assertThat(server.exitCode()).isEqualTo(STALLED);
        }
        Files.delete(folder.resolve("laws/spinning.so"));
        assertThat(shell.messages()).contains("a world stands still, and --stalled is exit");
        assertThat(resumed())
                .as("the frame that hung is the one that is lost")
                .isEqualTo(frame - 1);
    }

    @Test
    void aServerOutOfMemoryEndsAtOnceAndItsStoreIsWhole() throws Exception {
        try (Server server = serve("REVE_HEAP=64m", "--store my.db")) {
            act(server.port(), "hoard");
            List<JsonNode> events = server.events().untilEnd();
            assertThat(events)
                    .extracting(event -> event.path("event").asString())
                    .contains("joined")
                    .doesNotContain("end");
            assertThat(server.exitCode()).isEqualTo(OUT_OF_MEMORY);
        }
        assertThat(shell.messages())
                .contains("reve: out of memory: the heap may take 64m (REVE_HEAP)");
        assertThat(resumed()).isPositive();
    }

    /** Returns the frame from which a server resumes the store. The server ends regularly. */
    private long resumed() throws Exception {
        try (Server server = serve("", "--store my.db --seconds 0.1")) {
            long frame = server.events().await("ready", event -> true).path("frame").asLong();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
            return frame;
        }
    }
}
