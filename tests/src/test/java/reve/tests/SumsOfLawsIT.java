// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

/** Properties of a world file that several laws sum: the waterworks of docs/world-file.md. */
@Tag("slow")
class SumsOfLawsIT {
    /** Change of the difference of the levels in a step: 2 c dt / area, with two equal tanks. */
    private static final double RATE = 2 * 0.5 / 60 / 2;

    /** Rain of the page [m/s]. */
    private static final double RAIN = 0.020 / 3600;

    /** A stove and a pot. Texts and a law in Python add to the heat flows of each body. */
    private static final String KITCHEN =
            """
            reve: 1
            name: kitchen
            frame: {rate: 10}
            properties:
              - {name: temperature, kind: body, unit: K, min: 0}
              - {name: power, kind: body, unit: W}
              - {name: heating, kind: body, unit: W, access: accumulate}
              - {name: flux, kind: body, components: 3, unit: W/m^2, access: accumulate}
              - {name: sunshine, kind: body, components: 3, unit: W/m^2}
              - {name: ends, kind: contact, components: 2, refersTo: body}
              - {name: conductance, kind: contact, unit: W/K, min: 0}
            rules: {warms: physics.heating > 0}
            agents: {bodies: [pot]}
            laws:
              - text: |
                  law conduction "Heat flows through contacts."
                    each contact from a to b:
                      let flow = conductance (a.temperature - b.temperature)
                      a.heating -= flow;  b.heating += flow
              - stove
              - text: |
                  law light "Light that falls on bodies."
                    each body:
                      flux += (1, 0, 0) W/m^2
                      flux.z -= 2 W/m^2
              - text: |
                  law sun "The sum of all light."
                    each body: sunshine = flux
              - text: |
                  law warming "Heat changes the temperature of 100 J/K."
                    each body: temperature += heating dt / 100 J/K
            items:
              - {name: stove, physics: {mass: 9 kg, temperature: 300 K, power: 50 W}}
              - {name: pot, physics: {mass: 1 kg, temperature: 280 K}, access: {heat: {effects: [{set: physics.power, to: 10}]}}}
              - {name: base, kind: contact, physics: {ends: [stove, pot], conductance: 2 W/K}}
            """;

    private static final String STOVE =
            """
            # SPDX-License-Identifier: Apache-2.0
            import vesper


            @vesper.law(phase="force")
            def stove(heating: vesper.Accumulate("body", "W"), power: vesper.Read("body", "W")):
                \"""Heaters give heat.\"""
                heating += power
            """;

    @TempDir private Path folder;

    private static JsonNode json(Outcome outcome) {
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private static double[] numbers(WorldDescription world, String name, String property) {
        return world.items().stream()
                .filter(item -> item.name().equals(name))
                .findFirst()
                .orElseThrow()
                .physics(property)
                .orElseThrow();
    }

    private static double number(WorldDescription world, String name, String property) {
        return numbers(world, name, property)[0];
    }

    private Path waterworks() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/world-file.md"));
        return Files.writeString(
                folder.resolve("waterworks.yaml"),
                page.blocks().stream()
                        .map(Document.Block::text)
                        .filter(block -> block.contains("name: waterworks"))
                        .findFirst()
                        .orElseThrow());
    }

    private Path kitchen() throws Exception {
        Files.createDirectories(folder.resolve("laws"));
        Files.writeString(folder.resolve("laws/stove.py"), STOVE);
        return Files.writeString(folder.resolve("kitchen.yaml"), KITCHEN);
    }

    /** The pipe conserves the water, and each step begins its sums at 0. */
    @Test
    void twoTextsSumIntoAPropertyOfAnOwnKind() throws Exception {
        String world = waterworks().toString();
        Outcome check = Reve.run("check", world, "--strict");
        assertThat(check.code()).as(check.err()).isZero();
        Path saved = folder.resolve("saved.yaml");
        Path log = folder.resolve("run.log");
        String record = log.toString();
        JsonNode run =
                json(
                        Reve.run(
                                "run",
                                world,
                                "--seconds",
                                "1",
                                "--save",
                                saved.toString(),
                                "--record",
                                record,
                                "--json"));
        WorldDescription end = WorldFile.load(saved);
        double high = number(end, "high", "level");
        double low = number(end, "low", "level");
        assertThat(high - low).isCloseTo(2 * Math.pow(1 - RATE, 60), within(1e-12));
        assertThat(high + low).isCloseTo(4 + 2 * RAIN, within(1e-12));
        double flow = 0.5 * 2 * Math.pow(1 - RATE, 59);
        assertThat(number(end, "low", "inflow")).isCloseTo(flow + 2 * RAIN, within(1e-12));
        JsonNode replay = json(Reve.run("replay", record, "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
        assertThat(replay.path("stateHash")).isEqualTo(run.path("stateHash"));

        assertThat(Reve.run("check", saved.toString(), "--strict").code()).isZero();
        JsonNode whole = json(Reve.run("run", world, "--seconds", "2", "--json"));
        JsonNode rest = json(Reve.run("run", saved.toString(), "--seconds", "1", "--json"));
        assertThat(rest.path("stateHash"))
                .as("the saved world continues with the same bits")
                .isEqualTo(whole.path("stateHash"));
    }

    @Test
    void aLawInPythonAddsToTheSumOfTextsAndVectorsAreSums() throws Exception {
        String world = kitchen().toString();
        Outcome check = Reve.run("check", world, "--strict", "--trust");
        assertThat(check.code()).as(check.err() + check.out()).isZero();
        Path saved = folder.resolve("saved.yaml");
        Outcome run =
                Reve.run("run", world, "--seconds", "0.1", "--save", saved.toString(), "--trust");
        assertThat(run.code()).as(run.err()).isZero();
        WorldDescription end = WorldFile.load(saved);
        assertThat(number(end, "stove", "heating")).isEqualTo(50 - 2 * 20);
        assertThat(number(end, "pot", "heating")).isEqualTo(2 * 20);
        assertThat(number(end, "pot", "temperature")).isCloseTo(280 + 0.04, within(1e-12));
        assertThat(numbers(end, "pot", "sunshine")).containsExactly(1, 0, -2);
    }

    private static Outcome control(Server server, String... command) throws Exception {
        List<String> all = new ArrayList<>(List.of("control"));
        all.addAll(List.of(command));
        all.addAll(List.of("--port", server.port()));
        return Reve.run(all.toArray(String[]::new));
    }

    private static double heating(Server server, String item) throws Exception {
        for (JsonNode property : json(control(server, "inspect", "item=" + item)).get("physics")) {
            if (property.path("name").asString().equals("heating")) {
                return property.get("value").asDouble();
            }
        }
        throw new AssertionError(item);
    }

    @Test
    void anOperatorChangesWhatLawsAddButNotTheSum() throws Exception {
        String world = kitchen().toString();
        String store = folder.resolve("kept.db").toString();
        String log = folder.resolve("served.log").toString();
        try (Server server =
                Server.start(
                        folder,
                        "serve",
                        world,
                        "--port",
                        "0",
                        "--json",
                        "--trust",
                        "--store",
                        store,
                        "--record",
                        log)) {
            Outcome set = control(server, "change", "item=pot", "physics.heating=3");
            assertThat(set.code()).isEqualTo(1);
            assertThat(set.err())
                    .contains("heating", "the sum of what laws add in each step")
                    .contains("set a property that a law adds to it");
            Outcome edit =
                    control(server, "edit", "item=pot", "property=physics.heating", "value=3");
            assertThat(edit.code()).isEqualTo(1);
            assertThat(edit.err())
                    .contains(
                            "item pot: physics.heating is 3.0; it is the sum of what laws add in"
                                    + " each step, so it cannot be set");
            Path other =
                    Files.writeString(
                            folder.resolve("other.yaml"),
                            "{name: pan, physics: {temperature: 290 K, heating: 1 W}}\n");
            Outcome add = control(server, "add", other.toString());
            assertThat(add.code()).isEqualTo(1);
            assertThat(add.err()).contains("heating: found text `1 W`, expected no value");

            double before = heating(server, "stove");
            assertThat(control(server, "change", "item=stove", "physics.power=1000").code())
                    .isZero();
            assertThat(heating(server, "stove")).isGreaterThan(before + 400);
            assertThat(control(server, "unload-law", "library=stove").code()).isZero();
            assertThat(heating(server, "stove")).as("begins at 0 in each step").isLessThan(0);
            assertThat(control(server, "unload-law", "library=conduction").code()).isZero();
            assertThat(heating(server, "stove")).as("no law adds to it").isZero();
            server.process().toHandle().destroy();
            server.events().await("end", event -> true);
            assertThat(server.exitCode()).isZero();
        }
        JsonNode replay = json(Reve.run("replay", log, "--trust", "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
        try (Server server =
                Server.start(
                        folder, "serve", world, "--port", "0", "--json", "--trust", "--store",
                        store)) {
            assertThat(heating(server, "stove")).isZero();
        }
    }

    @ParameterizedTest(name = "{0}")
    @CsvSource(
            delimiter = '!',
            textBlock =
                    """
                    each tank: inflow = 0                        ! 'inflow' is the sum over all laws, so no law can set it
                    each tank: inflow += 0.1 inflow              ! 'inflow' is being summed by the laws of phase force, so this law cannot read it
                    each tank: level += 1 m; inflow += 1 m       ! '1 m' is m (a length), but 'inflow' is m^3/s
                    """)
    void checkRefusesTextsThatMisuseASum(String block, String message) throws Exception {
        Path file = waterworks();
        Files.writeString(
                file,
                Files.readString(file).replace("each tank: inflow += rate area", block.strip()));
        Outcome check = Reve.run("check", file.toString());
        assertThat(check.code()).as(check.err()).isEqualTo(4);
        assertThat(check.err()).contains("waterworks.yaml:", message);
    }
}
