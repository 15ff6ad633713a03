// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;

/** Pictures, videos and ontologies of a world whose law is quarantined before they are written. */
@Tag("slow")
class FaultsOfPicturesIT {
    @TempDir private Path folder;

    private String world = "";

    @BeforeEach
    void writeWorld() throws Exception {
        Path file =
                Files.writeString(
                        folder.resolve("blow.yaml"),
                        """
                        reve: 1
                        name: blow
                        laws:
                          - newton_motion
                          - text: |
                              law explode "Grows without bounds."
                                parameter k = 1000 N*s^2/m^2
                                each body: force += k |velocity| velocity
                        items:
                          - name: rock
                            physical: {shape: sphere, radius: 0.5}
                            physics: {mass: 1 kg, charge: 1, velocity: [1, 0, 0]}
                        """);
        world = file.toString();
    }

    private void hasReportedTheFault(Outcome outcome, Path written) {
        assertThat(outcome.code()).as(outcome.err()).isEqualTo(1);
        assertThat(outcome.messages())
                .contains("blow.yaml:12:", "no law of this world reads the charge of rock")
                .contains("reve: fault in frame ", "law explode: property externalForce");
        assertThat(written).isNotEmptyFile();
    }

    @Test
    void aSnapshotIsWrittenAndTheFaultIsReported() throws Exception {
        Path picture = folder.resolve("a.png");
        hasReportedTheFault(
                Reve.run("picture", world, "--at", "1", "--out", picture.toString()), picture);
        Path before = folder.resolve("b.png");
        Outcome begin = Reve.run("picture", world, "--out", before.toString());
        assertThat(begin.code()).as(begin.err()).isZero();
        assertThat(begin.messages()).contains("reads the charge").doesNotContain("fault");
    }

    @Test
    void aVideoIsWrittenAndTheFaultIsReported() throws Exception {
        Path video = folder.resolve("a.gif");
        hasReportedTheFault(
                Reve.run(
                        "video",
                        world,
                        "--seconds",
                        "0.5",
                        "--fps",
                        "10",
                        "--size",
                        "64x64",
                        "--out",
                        video.toString()),
                video);
    }

    @Test
    void anOntologyIsWrittenAndTheFaultIsReported() throws Exception {
        Path ontology = folder.resolve("a.jsonld");
        Outcome outcome =
                Reve.run("export", world, "--at", "1", "--json-ld", ontology.toString(), "--json");
        hasReportedTheFault(outcome, ontology);
        JsonNode result = new JsonMapper().readTree(outcome.out());
        assertThat(result.path("faults").path(0).path("library").asString()).isEqualTo("explode");
        assertThat(result.path("warnings").size()).isEqualTo(1);
    }
}
