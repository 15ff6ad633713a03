// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;

import javax.imageio.ImageIO;

/** {@code ./reve demo}: three processes, a law that is loaded and unloaded, two pictures. */
class DemoIT {
    @TempDir private Path folder;

    @Test
    void everyPartOfTheMainJobHappens() throws Exception {
        Outcome outcome = Reve.runAsProcess("demo", "--json", "--out", folder.toString());
        assertThat(outcome.code()).as(outcome.err()).isZero();
        JsonNode demo = new JsonMapper().readTree(outcome.out());

        assertThat(demo.at("/server/frames").asLong()).isGreaterThanOrEqualTo(5 * 60);
        assertThat(demo.at("/server/faults").size()).isZero();
        assertThat(demo.at("/server/agents/joined").asLong()).isEqualTo(2);
        assertThat(demo.at("/server/agents/cut").asLong()).isZero();
        assertThat(demo.at("/lawLoaded/time").asDouble())
                .isGreaterThanOrEqualTo(2)
                .isLessThan(demo.at("/lawUnloaded/time").asDouble());
        for (String agent : new String[] {"pythonAgent", "javaAgent"}) {
            assertThat(demo.path(agent).path("perceptions").asLong()).as(agent).isGreaterThan(10);
            assertThat(demo.path(agent).path("actsRefused").size()).as(agent).isZero();
        }
        assertThat(demo.at("/pythonAgent/pushes").asLong()).isPositive();
        assertThat(demo.at("/javaAgent/painted/red").asString()).startsWith("#");
        byte[][] pictures = new byte[2][];
        for (int i = 0; i < 2; i++) {
            Path file = Path.of(demo.at("/pictures/" + i + "/file").asString());
            assertThat(ImageIO.read(file.toFile()).getWidth()).isEqualTo(960);
            pictures[i] = Files.readAllBytes(file);
        }
        assertThat(pictures[0]).isNotEqualTo(pictures[1]);
    }

    @Test
    void aPictureThatFailsEndsItWithTheReason() throws Exception {
        Path inTheWay = Files.createDirectory(folder.resolve("spring-orbit-000120.png"));

        Outcome outcome = Reve.run("demo", "--out", folder.toString());

        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err()).contains("picture failed", inTheWay.toString());
    }
}
