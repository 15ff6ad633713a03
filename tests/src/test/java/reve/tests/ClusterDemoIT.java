// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;

import javax.imageio.ImageIO;

/** {@code ./reve demo cluster}: three servers, of which one is killed, and two pictures. */
@Tag("slow")
class ClusterDemoIT {
    @TempDir private Path folder;

    @Test
    void theWorldOfAKilledServerContinuesOnAnother() throws Exception {
        Outcome outcome =
                Reve.runAsProcess("demo", "cluster", "--json", "--out", folder.toString());
        assertThat(outcome.code()).as(outcome.err()).isZero();
        JsonNode demo = new JsonMapper().readTree(outcome.out());
        assertThat(demo.path("nodes"))
                .hasSize(3)
                .extracting(JsonNode::asString)
                .contains(demo.path("killed").asString(), demo.path("continued").asString());
        assertThat(demo.path("continued").asString()).isNotEqualTo(demo.path("killed").asString());
        assertThat(demo.path("epoch").asLong()).isEqualTo(2);
        assertThat(demo.path("resumedFrame").asLong())
                .as("at most the frame that was being written is lost")
                .isGreaterThanOrEqualTo(demo.path("seenFrame").asLong() - 1);
        assertThat(demo.path("same").asBoolean()).isTrue();
        assertThat(demo.path("stateHash").asString())
                .matches("[0-9a-f]{16}")
                .isEqualTo(demo.path("undisturbedHash").asString());
        assertThat(demo.at("/before/frame").asLong())
                .isLessThanOrEqualTo(demo.path("seenFrame").asLong());
        assertThat(demo.at("/after/frame").asLong())
                .isGreaterThan(demo.path("resumedFrame").asLong());
        byte[][] pictures = new byte[2][];
        for (int i = 0; i < 2; i++) {
            Path file = Path.of(demo.at(i == 0 ? "/before/file" : "/after/file").asString());
            assertThat(ImageIO.read(file.toFile()).getWidth()).isEqualTo(960);
            pictures[i] = Files.readAllBytes(file);
        }
        assertThat(pictures[0]).isNotEqualTo(pictures[1]);
    }

    @Test
    void withoutPostgresItSaysWhatToInstall() throws Exception {
        Outcome outcome =
                Reve.run(
                        "demo",
                        "cluster",
                        "--out",
                        folder.toString(),
                        "--postgres",
                        folder.toString());
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err())
                .contains(
                        "found no initdb, postgres and pg_isready in " + folder,
                        "apt-get install postgresql");
    }
}
