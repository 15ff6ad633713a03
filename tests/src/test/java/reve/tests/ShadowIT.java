// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Join;

import tools.jackson.databind.JsonNode;

import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.util.List;
import java.util.Map;

/** New versions of laws that act in the shadow of a served world before they take over. */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class ShadowIT {
    @TempDir private Path folder;

    private StoneWorld world;

    @BeforeEach
    void makeWorld() throws Exception {
        world = StoneWorld.in(folder);
    }

    /** Puts a test law into the file wind.so of the laws folder. */
    private void drop(String law) throws Exception {
        Path copy =
                Files.copy(
                        Project.NATIVE
                                .resolve("adapter-test-laws")
                                .resolve("libvesper_law_" + law + ".so"),
                        folder.resolve("copy.so"));
        Files.move(copy, world.laws().resolve("wind.so"), StandardCopyOption.REPLACE_EXISTING);
    }

    private static JsonNode awaitEnd(Server server, int seen) throws Exception {
        return server.events()
                .await(
                        "law-shadow",
                        event ->
                                server.events().isAfter(event, seen)
                                        && (event.path("stage").asString().equals("refused")
                                                || event.path("stage")
                                                        .asString()
                                                        .equals("accepted")));
    }

    @Test
    void aVersionThatHarmsItsProcessNeverReachesTheWorld() throws Exception {
        Path log = folder.resolve("run.log");
        try (Server server = world.serve("--record", log.toString())) {
            try (AgentClient agent = Agents.join(Integer.parseInt(server.port()), "ada")) {
                drop("wind");
                server.events()
                        .await(
                                "law-loaded",
                                event -> event.path("library").asString().equals("wind"));
                while (agent.perceive().frame() <= StoneWorld.HARMLESS_STEPS) {}
                for (Map.Entry<String, String> kind :
                        List.of(
                                Map.entry("segfault", "LAW_CRASHED"),
                                Map.entry("loop", "LAW_TIMED_OUT"))) {
                    int seen = server.events().count();
                    drop("hostile_" + kind.getKey());
                    JsonNode end = awaitEnd(server, seen);
                    assertThat(end.path("stage").asString()).isEqualTo("refused");
                    assertThat(end.path("status").asString())
                            .as(end.toString())
                            .isEqualTo(kind.getValue());
                    assertThat(end.path("message").asString())
                            .contains("of 60 of its shadow: law hostile");
                }
                int seen = server.events().count();
                drop("strong_wind");
                JsonNode end = awaitEnd(server, seen);
                assertThat(end.path("stage").asString()).as(end.toString()).isEqualTo("accepted");
                assertThat(end.path("frames").asInt()).isEqualTo(60);
                assertThat(end.path("position").asDouble()).isPositive();
                assertThat(agent.perceive()).isNotNull();
            }
            server.events().await("left", event -> true);
            server.process().toHandle().destroy();
            List<JsonNode> events = server.events().untilEnd();
            assertThat(events).noneMatch(Server::isFault);
            assertThat(server.exitCode()).isZero();
        }
        Reve.Outcome replay = Reve.run("replay", log.toString(), "--trust");
        assertThat(replay.out()).contains("identical: ");
    }

    /**
     * The store's image needs the bytes of the version before, which are in no folder any more. The
     * file that was on trial is tried again.
     */
    @Test
    void aWorldThatIsKilledBeforeAndAfterANewVersionTakesOverGoesOn() throws Exception {
        String store = folder.resolve("k.db").toString();
        try (Server server = world.serve("--store", store, "--shadow-seconds", "100")) {
            server.port();
            drop("wind");
            server.events()
                    .await("law-loaded", event -> event.path("library").asString().equals("wind"));
            drop("strong_wind");
            server.events()
                    .await("law-shadow", event -> event.path("stage").asString().equals("begins"));
            server.process().toHandle().destroyForcibly();
        }
        try (Server server = world.serve("--store", store, "--shadow-seconds", "0.2")) {
            JsonNode end = awaitEnd(server, 0);
            assertThat(end.path("stage").asString()).as(end.toString()).isEqualTo("accepted");
            server.process().toHandle().destroyForcibly();
        }
        try (Server server = world.serve("--store", store);
                AgentClient boss =
                        Agents.join(
                                Integer.parseInt(server.port()),
                                Join.as("boss").withRole("control"))) {
            assertThat(boss.report("laws", Map.of()).content().get("loaded").toString())
                    .contains("wind");
            server.process().toHandle().destroy();
            assertThat(server.events().untilEnd()).noneMatch(Server::isFault);
        }
    }

    private static final String PUSH = "law push\n  each body: force += %s N (1, 0, 0)\n";

    /** Loads a text, and then another version of it, which is tried first. */
    private static void tryText(AgentClient boss) {
        Map<String, Object> first = Map.of("library", "push.law", "text", PUSH.formatted("1"));
        assertThat(boss.command("load-law", first).accepted()).isTrue();
        Map<String, Object> tried =
                Map.of("library", "push.law", "text", PUSH.formatted("2"), "swap", "shadow");
        assertThat(boss.command("load-law", tried).accepted()).isTrue();
    }

    /** The trial does not end in this test. */
    @Test
    void anOperatorSeesHowFarATextDiverges() throws Exception {
        try (Server server = world.serve("--shadow-seconds", "30");
                AgentClient boss =
                        Agents.join(
                                Integer.parseInt(server.port()),
                                Join.as("boss").withRole("control"))) {
            tryText(boss);
            JsonNode runs =
                    server.events()
                            .await(
                                    "law-shadow",
                                    event -> event.path("stage").asString().equals("runs"));
            assertThat(runs.path("of").asInt()).isEqualTo(1800);
            assertThat(boss.report("laws", Map.of()).content()).containsKey("trials");
            assertThat(runs.path("positionItem").asString()).isEqualTo("stone");
        }
    }

    @Test
    void anOperatorChoosesHowATextTakesOver() throws Exception {
        try (Server server = world.serve("--shadow-seconds", "0.5");
                AgentClient boss =
                        Agents.join(
                                Integer.parseInt(server.port()),
                                Join.as("boss").withRole("control"))) {
            tryText(boss);
            JsonNode end = awaitEnd(server, 0);
            assertThat(end.path("stage").asString()).as(end.toString()).isEqualTo("accepted");
            int seen = server.events().count();
            Map<String, Object> atOnce = Map.of("library", "push.law", "text", PUSH.formatted("3"));
            assertThat(boss.command("load-law", atOnce).accepted()).isTrue();
            JsonNode loaded =
                    server.events()
                            .await("law-loaded", event -> server.events().isAfter(event, seen));
            assertThat(loaded.path("library").asString()).isEqualTo("push");
            assertThat(boss.report("laws", Map.of()).content()).doesNotContainKey("trials");
            assertThatThrownBy(
                            () ->
                                    boss.command(
                                            "set-law", Map.of("library", "push", "swap", "later")))
                    .hasMessageContaining("swap is \"later\" (expected shadow or at-once)");
        }
    }

    /** The server's rule {@code --swap shadow} also holds for parameters. */
    @Test
    void parametersOfAMessageAndOfAFileAreTriedToo() throws Exception {
        Path log = folder.resolve("run.log");
        Files.writeString(
                world.laws().resolve("push.law"),
                "law push\n  parameter f = 1 N, from 0 N to 1000 N\n"
                        + "  each body: force += f (1, 0, 0)\n");
        try (Server server =
                world.serve(
                        "--swap",
                        "shadow",
                        "--shadow-seconds",
                        "0.5",
                        "--record",
                        log.toString())) {
            try (AgentClient boss =
                    Agents.join(
                            Integer.parseInt(server.port()), Join.as("boss").withRole("control"))) {
                server.events()
                        .await(
                                "law-loaded",
                                event -> event.path("library").asString().equals("push"));
                int seen = server.events().count();
                Map<String, Object> three =
                        Map.of("library", "push", "parameters", Map.of("f", 3.0));
                assertThat(boss.command("set-law", three).accepted()).isTrue();
                JsonNode end = awaitEnd(server, seen);
                assertThat(end.path("stage").asString()).as(end.toString()).isEqualTo("accepted");
                assertThat(end.path("frames").asInt()).isEqualTo(30);
                assertThat(end.path("parameters").asString()).isEqualTo("f = 3.0");

                seen = server.events().count();
                Files.writeString(world.laws().resolve("push.yaml"), "f: 0.9 kN\n");
                end = awaitEnd(server, seen);
                assertThat(end.path("stage").asString()).as(end.toString()).isEqualTo("refused");
                assertThat(end.path("parameters").asString()).isEqualTo("f = 900.0");
                assertThat(end.path("energy").asDouble())
                        .isGreaterThan(end.path("mostEnergy").asDouble());
                assertThat(boss.report("laws", Map.of()).content().get("loaded").toString())
                        .contains("value=3.0");

                int before = server.events().count();
                Map<String, Object> two =
                        Map.of(
                                "library",
                                "push",
                                "parameters",
                                Map.of("f", 2.0),
                                "swap",
                                "at-once");
                assertThat(boss.command("set-law", two).accepted()).isTrue();
                server.events()
                        .await("law-loaded", event -> server.events().isAfter(event, before));
                assertThat(boss.report("laws", Map.of()).content()).doesNotContainKey("trials");
            }
            server.process().toHandle().destroy();
            server.events().untilEnd();
            assertThat(server.exitCode()).isZero();
        }
        Reve.Outcome replay = Reve.run("replay", log.toString(), "--trust");
        assertThat(replay.out()).contains("identical: ");
    }
}
