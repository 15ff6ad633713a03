// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** Kinds of the designer that refer to items: the tanks of docs/world-file.md. */
@Tag("slow")
class OwnKindsIT {
    /** Change of the difference of the levels in a step: 2 c dt / area, with two equal tanks. */
    private static final double RATE = 2 * 0.5 / 60 / 2;

    @TempDir private Path folder;
    private Path tanks;

    @BeforeEach
    void writeTheWorldOfThePage() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/world-file.md"));
        String text =
                page.blocks().stream()
                        .map(Document.Block::text)
                        .filter(block -> block.contains("name: tanks"))
                        .findFirst()
                        .orElseThrow();
        tanks = Files.writeString(folder.resolve("tanks.yaml"), text);
    }

    private static JsonNode json(Outcome outcome) {
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private static double level(WorldDescription world, String tank) {
        return world.items().stream()
                .filter(item -> item.name().equals(tank))
                .findFirst()
                .orElseThrow()
                .physics("level")
                .orElseThrow()[0];
    }

    /** The difference of the levels decays geometrically, and no water is lost. */
    @Test
    void aTextJoinsRowsThroughTheirReferences() throws Exception {
        Outcome check = Reve.run("check", tanks.toString(), "--strict");
        assertThat(check.code()).as(check.err()).isZero();
        Path saved = folder.resolve("saved.yaml");
        Path log = folder.resolve("run.log");
        JsonNode run =
                json(
                        Reve.run(
                                "run",
                                tanks.toString(),
                                "--seconds",
                                "1",
                                "--save",
                                saved.toString(),
                                "--record",
                                log.toString(),
                                "--json"));
        WorldDescription end = WorldFile.load(saved);
        double high = level(end, "high");
        double low = level(end, "low");
        assertThat(high - low).isCloseTo(2 * Math.pow(1 - RATE, 60), within(1e-12));
        assertThat(high + low).isCloseTo(4, within(1e-12));
        JsonNode replay = json(Reve.run("replay", log.toString(), "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
        assertThat(replay.path("stateHash")).isEqualTo(run.path("stateHash"));

        JsonNode whole = json(Reve.run("run", tanks.toString(), "--seconds", "2", "--json"));
        JsonNode rest = json(Reve.run("run", saved.toString(), "--seconds", "1", "--json"));
        assertThat(rest.path("stateHash"))
                .as("the saved world continues with the same bits")
                .isEqualTo(whole.path("stateHash"));
    }

    private static Outcome control(Server server, String... command) throws Exception {
        List<String> all = new ArrayList<>(List.of("control"));
        all.addAll(List.of(command));
        all.addAll(List.of("--port", server.port()));
        return Reve.run(all.toArray(String[]::new));
    }

    private static double level(Server server, String tank) throws Exception {
        Outcome report = control(server, "inspect", "item=" + tank);
        assertThat(report.code()).as(report.err()).isZero();
        for (JsonNode property : new JsonMapper().readTree(report.out()).get("physics")) {
            if (property.path("name").asString().equals("level")) {
                return property.get("value").asDouble();
            }
        }
        throw new AssertionError(report.out());
    }

    @Test
    void anOperatorChangesReferencesOfARunningWorld() throws Exception {
        Path log = folder.resolve("served.log");
        Path third =
                Files.writeString(
                        folder.resolve("third.yaml"),
                        "{name: third, kind: tank, physics: {level: 0 m, area: 2 m^2}}\n");
        Path drain =
                Files.writeString(
                        folder.resolve("drain.yaml"),
                        """
                        name: drain
                        kind: pipe
                        physics: {ends: [third, low], conductance: 4 m^2/s}
                        """);
        Path lone =
                Files.writeString(
                        folder.resolve("lone.yaml"),
                        "{name: lone, kind: pipe, physics: {conductance: 1 m^2/s}}\n");
        Path turn =
                Files.writeString(
                        folder.resolve("turn.yaml"),
                        "{name: pipe, physics: {ends: [high, third]}}\n");
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        tanks.toString(),
                        "--port",
                        "0",
                        "--json",
                        "--record",
                        log.toString())) {
            assertThat(control(server, "add", third.toString()).code()).isZero();
            assertThat(control(server, "change", turn.toString()).code()).isZero();
            double low = level(server, "low");
            control(server, "pause");
            control(server, "step", "frames=5");
            assertThat(level(server, "low")).as("no pipe ends at it any more").isEqualTo(low);
            assertThat(level(server, "third")).isPositive();
            control(server, "run");

            Outcome taken = control(server, "remove", "item=third");
            assertThat(taken.code()).isEqualTo(1);
            assertThat(taken.err()).contains("third", "pipe", "refers to it");
            Outcome wrong = control(server, "change", "item=pipe", "physics.ends=high");
            assertThat(wrong.code()).isEqualTo(1);
            assertThat(wrong.err())
                    .contains(
                            "ends: found text `high`, expected a list of 2 names of items of kind");
            Outcome missing = control(server, "add", lone.toString());
            assertThat(missing.code()).isEqualTo(1);
            assertThat(missing.err())
                    .contains(
                            "/items/0/physics: a pipe needs `ends`: 2 names of items of kind tank");
            assertThat(control(server, "add", drain.toString()).code()).isZero();
            assertThat(control(server, "remove", "item=third", "cascade=true").code()).isZero();
            assertThat(control(server, "inspect", "item=pipe").code()).isEqualTo(1);

            server.process().toHandle().destroy();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }
        JsonNode replay = json(Reve.run("replay", log.toString(), "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
        assertThat(replay.path("frames").asLong()).isPositive();
    }
}
