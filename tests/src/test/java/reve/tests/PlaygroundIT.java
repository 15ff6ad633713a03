// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Path;

/**
 * {@code worlds/playground}: a Python agent rolls its body against toys. Only a law of contact
 * moves the toys.
 */
@Tag("slow")
class PlaygroundIT {
    @TempDir private Path folder;

    @Test
    void aCuriousAgentGoesToTheRedBallAndPushesItAway() throws Exception {
        var shell = new Shell(folder);
        try (Server server = shell.serve("\"$REVE/reve\" serve \"$REVE/worlds/playground\"")) {
            String summary =
                    shell.run(
                            "PYTHONPATH=\"$REVE/agents/python\" python3"
                                    + " \"$REVE/agents/python/examples/curious.py\" --seconds 8 --port "
                                    + server.port());
            JsonNode curious = new JsonMapper().readTree(summary);
            assertThat(curious.path("moved").path(0).asString("")).as(summary).isEqualTo("red");
            assertThat(curious.path("actsRefused").size()).as(summary).isZero();
            assertThat(curious.path("ended").asString()).isEqualTo("done");
        }
    }
}
