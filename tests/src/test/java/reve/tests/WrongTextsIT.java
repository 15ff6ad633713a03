// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Join;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** A wrong text costs its author nothing but the message, and the world nothing at all. */
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
@Tag("slow")
class WrongTextsIT {
    /** The texts have the name of the law {@code x}, which both worlds have loaded. */
    private static final String LAWS =
            """
            laws:
              - hooke_spring
              - newton_motion
              - text: |
                  law x
                    each body:
                      let air = 2 1/s (0, 1, 0) × position
                      force += 1 kg/s (air - velocity)
            """;

    private record Wrong(String text, String message) {}

    private static List<Wrong> wrongTexts() throws IOException {
        String file =
                Files.readString(Project.ROOT.resolve("vesper-native/text/test/wrong_texts.txt"));
        List<Wrong> texts = new ArrayList<>();
        for (String each : file.split("(?m)^====\\n")) {
            String[] parts = each.split("(?m)^----\\n");
            if (parts.length == 2) {
                texts.add(new Wrong(parts[0], parts[1].lines().findFirst().orElseThrow()));
            }
        }
        assertThat(texts).hasSizeGreaterThan(200);
        return texts;
    }

    private static Path world(Path folder, String name) throws IOException {
        String sandbox = Files.readString(Project.WORLDS.resolve("sandbox/world.yaml"));
        String text =
                sandbox.replace("name: sandbox", "name: " + name)
                        .replace("laws: [hooke_spring, newton_motion]\n", LAWS);
        assertThat(text).contains("law x", "name: " + name);
        return Files.writeString(folder.resolve(name + ".yaml"), text);
    }

    private static AgentClient boss(Server server, String world) throws Exception {
        return Agents.join(
                Integer.parseInt(server.port()),
                Join.as("boss").withRole("control").withWorld(world));
    }

    private static long command(AgentClient boss, String command, Map<String, Object> fields)
            throws Exception {
        ActResult result = boss.command(command, fields);
        assertThat(result.accepted()).as(result.toString()).isTrue();
        return result.frame().orElse(0);
    }

    /** Waits until a paused world has made all frames up to {@code end}. */
    private static void awaitFrames(Server server, String world, long end) throws Exception {
        JsonNode state;
        do {
            Reve.Outcome asked =
                    Reve.run("control", "state", "--port", server.port(), "--world", world);
            assertThat(asked.code()).as(asked.err()).isZero();
            state = new JsonMapper().readTree(asked.out());
            assertThat(state.get("frames").longValue()).isLessThanOrEqualTo(end);
        } while (state.get("frames").longValue() < end);
    }

    private static ActResult load(AgentClient boss, String text) throws Exception {
        return boss.command("load-law", Map.of("library", "x.law", "text", text));
    }

    @Test
    void aWorldUnderWrongTextsHasTheBitsOfOneThatGetsNone(@TempDir Path folder) throws Exception {
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        world(folder, "calm").toString(),
                        world(folder, "bombarded").toString(),
                        "--port",
                        "0",
                        "--json")) {
            try (AgentClient calm = boss(server, "calm");
                    AgentClient bombarded = boss(server, "bombarded")) {
                for (Wrong wrong : wrongTexts()) {
                    if (wrong.text().isEmpty()) { // the server reads the field before the text
                        assertThatThrownBy(() -> load(bombarded, wrong.text()))
                                .isInstanceOf(AgentException.class)
                                .hasMessageContaining("the field text is \"\"");
                        continue;
                    }
                    ActResult refused = load(bombarded, wrong.text());
                    assertThat(refused.accepted()).as(wrong.text()).isFalse();
                    assertThat(refused.code()).as(wrong.text()).contains("law-refused");
                    assertThat(refused.reason().orElseThrow())
                            .as(wrong.text())
                            .contains(wrong.message());
                }
                String named = "law newton_motion\n  each body:\n    force += (1, 0, 0) N\n";
                for (String library : List.of("x.law", "README.md")) { // the latter is a file
                    ActResult shipped =
                            bombarded.command(
                                    "load-law", Map.of("library", library, "text", named));
                    assertThat(shipped.code()).contains("law-refused");
                    assertThat(shipped.reason().orElseThrow())
                            .contains("the law calls itself 'newton_motion', which is the name of")
                            .doesNotContain(Project.ROOT.toString());
                }
                command(calm, "pause", Map.of());
                command(bombarded, "pause", Map.of());
                long one = command(calm, "step", Map.of("frames", 1));
                long other = command(bombarded, "step", Map.of("frames", 1));
                long end = Math.max(one, other) + 60;
                command(calm, "step", Map.of("frames", end - one));
                command(bombarded, "step", Map.of("frames", end - other));
                awaitFrames(server, "calm", end);
                awaitFrames(server, "bombarded", end);
                command(calm, "shut-down", Map.of());
                command(bombarded, "shut-down", Map.of());
            }
            JsonNode report = server.events().await("end", event -> true);
            JsonNode worlds = report.get("worlds");
            assertThat(worlds).hasSize(2);
            assertThat(worlds.get(0).get("frames")).isEqualTo(worlds.get(1).get("frames"));
            assertThat(worlds.get(0).get("stateHash").asString()).isNotEmpty();
            assertThat(worlds.get(0).get("stateHash")).isEqualTo(worlds.get(1).get("stateHash"));
            assertThat(worlds.get(1).get("faults")).isEmpty();
        }
    }
}
