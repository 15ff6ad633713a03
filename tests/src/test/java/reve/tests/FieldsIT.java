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

/** Fields that a world file declares: the regatta of docs/world-file.md. */
@Tag("slow")
class FieldsIT {
    @TempDir private Path folder;
    private Path regatta = Path.of("");

    @BeforeEach
    void writeTheWorldOfThePage() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/world-file.md"));
        regatta =
                Files.writeString(
                        folder.resolve("regatta.yaml"),
                        page.blocks().stream()
                                .map(Document.Block::text)
                                .filter(block -> block.contains("name: regatta"))
                                .findFirst()
                                .orElseThrow());
    }

    private static JsonNode json(Outcome outcome) {
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private static double[] velocity(WorldDescription world, String name) {
        return world.items().stream()
                .filter(item -> item.name().equals(name))
                .findFirst()
                .orElseThrow()
                .physics("velocity")
                .orElseThrow();
    }

    private static double speed(WorldDescription world, String name) {
        return velocity(world, name)[0];
    }

    /** Each boat comes closer to the wind at its height, by the factor 1 - c dt / m in a step. */
    @Test
    void aTextReadsTheFieldThatAnotherOneProvides() throws Exception {
        Outcome check = Reve.run("check", regatta.toString(), "--strict");
        assertThat(check.code()).as(check.err()).isZero();
        Path saved = folder.resolve("saved.yaml");
        Path log = folder.resolve("run.log");
        JsonNode run =
                json(
                        Reve.run(
                                "run",
                                regatta.toString(),
                                "--seconds",
                                "1",
                                "--save",
                                saved.toString(),
                                "--record",
                                log.toString(),
                                "--json"));
        double left = Math.pow(1 - 2.0 / 60, 60);
        WorldDescription end = WorldFile.load(saved);
        assertThat(speed(end, "low")).isCloseTo(2 * (1 - left), within(1e-12));
        assertThat(speed(end, "high")).isCloseTo(6 * (1 - left), within(1e-12));
        assertThat(end.prototype().fields()).hasSize(1);
        JsonNode replay = json(Reve.run("replay", log.toString(), "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
        assertThat(replay.path("stateHash")).isEqualTo(run.path("stateHash"));

        JsonNode whole = json(Reve.run("run", regatta.toString(), "--seconds", "2", "--json"));
        JsonNode rest = json(Reve.run("run", saved.toString(), "--seconds", "1", "--json"));
        assertThat(rest.path("stateHash")).isEqualTo(whole.path("stateHash"));
    }

    /**
     * The wind across is 1 m/s^2 t. With c / m = 2/s, the speed after n steps is t - 1/2 s + (1 -
     * 2/s dt)^n / 2 s, times 1 m/s^2.
     */
    @Test
    void aFieldDependsOnTheTimeOfTheWorld() throws Exception {
        Files.writeString(
                regatta,
                Files.readString(regatta)
                        .replace("(shear place.y, 0, 0)", "(shear place.y, 0, 1 m/s^2 time)"));
        Path saved = folder.resolve("saved.yaml");
        Path log = folder.resolve("run.log");
        List<String> command =
                List.of("run", regatta.toString(), "--save", saved.toString(), "--json");
        List<String> recorded = new ArrayList<>(command);
        recorded.addAll(List.of("--seconds", "1", "--record", log.toString()));
        JsonNode run = json(Reve.run(recorded.toArray(String[]::new)));
        WorldDescription end = WorldFile.load(saved);
        for (String boat : List.of("low", "high")) {
            assertThat(velocity(end, boat)[2])
                    .isCloseTo(1 - 0.5 + Math.pow(1 - 2.0 / 60, 60) / 2, within(1e-12));
        }
        JsonNode replay = json(Reve.run("replay", log.toString(), "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
        assertThat(replay.path("stateHash")).isEqualTo(run.path("stateHash"));
        JsonNode rest = json(Reve.run("run", saved.toString(), "--seconds", "1", "--json"));
        JsonNode whole = json(Reve.run("run", regatta.toString(), "--seconds", "2", "--json"));
        assertThat(rest.path("stateHash")).isEqualTo(whole.path("stateHash"));
    }

    /** The wind is infinite at the height of the boat "low", 1 m. */
    @Test
    void aFieldWithoutAFiniteNumberIsTheFaultOfTheLawThatProvidesIt() throws Exception {
        Files.writeString(
                regatta,
                Files.readString(regatta)
                        .replace(
                                "(shear place.y, 0, 0)",
                                "shear place.y / (place.y - 1 m) * (1 m, 0, 0)"));
        Path log = folder.resolve("run.log");
        Path saved = folder.resolve("saved.yaml");
        Outcome run =
                Reve.run(
                        "run",
                        regatta.toString(),
                        "--seconds",
                        "0.5",
                        "--save",
                        saved.toString(),
                        "--record",
                        log.toString(),
                        "--json");
        JsonNode report = new JsonMapper().readTree(run.out());
        assertThat(report.path("faults").size()).as(run.out() + run.err()).isEqualTo(1);
        JsonNode fault = report.path("faults").get(0);
        assertThat(fault.path("library").asString()).isEqualTo("breeze");
        assertThat(fault.path("law").asString()).isEqualTo("breeze");
        assertThat(fault.path("message").asString())
                .contains("breeze.law:3:", "field wind: '", "divides by zero at (0, 1, 0) m")
                .contains("where law sail reads it");
        assertThat(WorldFile.load(saved).items())
                .as("sail rests, and a saved world omits velocities of 0")
                .allSatisfy(boat -> assertThat(boat.physics("velocity")).isEmpty());
        JsonNode replay = json(Reve.run("replay", log.toString(), "--json"));
        assertThat(replay.path("identical").asBoolean()).isTrue();
    }

    @Test
    void aLawInPythonReadsTheField() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/laws-in-python.md"));
        Files.writeString(
                Files.createDirectory(folder.resolve("laws")).resolve("sail.py"),
                page.titled("sail.py").text());
        String text = "(?s)  - text: \\|\\n      law sail.*?(?=  - newton_motion)";
        Files.writeString(regatta, Files.readString(regatta).replaceFirst(text, "  - sail\n"));
        Path saved = folder.resolve("saved.yaml");
        JsonNode run =
                json(
                        Reve.run(
                                "run",
                                regatta.toString(),
                                "--trust",
                                "--seconds",
                                "1",
                                "--save",
                                saved.toString(),
                                "--json"));
        assertThat(run.path("faults")).isEmpty();
        double left = Math.pow(1 - 2.0 / 60, 60);
        assertThat(speed(WorldFile.load(saved), "high")).isCloseTo(6 * (1 - left), within(1e-12));
    }

    /** The wind of the page, and the closed form of a boat that follows it. */
    @Test
    void aFileInPythonProvidesTheField() throws Exception {
        Document page = Document.read(Project.ROOT.resolve("docs/laws-in-python.md"));
        Path laws = Files.createDirectory(folder.resolve("laws"));
        for (String law : List.of("wind.py", "sail.py")) {
            Files.writeString(laws.resolve(law), page.titled(law).text());
        }
        Path world = folder.resolve("python.yaml");
        Files.writeString(world, page.titled("regatta.yaml").text());
        Outcome check = Reve.run("check", world.toString(), "--trust", "--strict");
        assertThat(check.code()).as(check.err()).isZero();
        Path saved = folder.resolve("saved.yaml");
        JsonNode run =
                json(
                        Reve.run(
                                "run",
                                world.toString(),
                                "--trust",
                                "--seconds",
                                "1",
                                "--save",
                                saved.toString(),
                                "--json"));
        assertThat(run.path("faults")).isEmpty();
        double left = Math.pow(1 - 2.0 / 60, 60); // 2 kg/s on 1 kg at 60 steps a second
        assertThat(speed(WorldFile.load(saved), "low")).isCloseTo(0.5 * (1 - left), within(1e-12));
    }

    /** A trap with the force -k x: the shipped law reads the field, which a text provides. */
    @Test
    void aCompiledLawReadsTheFieldThatATextProvides() throws Exception {
        Path trap =
                Files.writeString(
                        folder.resolve("trap.yaml"),
                        """
                        reve: 1
                        name: trap
                        laws:
                          - text: |
                              law trap "Pulls towards the origin."
                                parameter k = 1 N/m
                                field forceField at place = -k place
                            parameters: {k: 3 N/m}
                          - force_field
                          - newton_motion
                        items:
                          - {name: bead, physical: {location: [2, 0, 0]}, physics: {mass: 1 kg}}
                        """);
        Outcome check = Reve.run("check", trap.toString(), "--strict");
        assertThat(check.code()).as(check.err()).isZero();
        Path saved = folder.resolve("saved.yaml");
        Outcome run =
                Reve.run("run", trap.toString(), "--seconds", "0.01", "--save", saved.toString());
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(speed(WorldFile.load(saved), "bead")).isCloseTo(-6.0 / 60, within(1e-15));
    }

    /** A trap with the energy k r^2 / 2, which is a field: its force is -k r. */
    @Test
    void anEnergyGetsItsForceFromTheSlopeOfAField() throws Exception {
        Path trap =
                Files.writeString(
                        folder.resolve("trap.yaml"),
                        """
                        reve: 1
                        name: trap
                        properties:
                          - {name: depth, kind: world, type: field, unit: J}
                        laws:
                          - text: |
                              law well
                                parameter k = 1 N/m
                                field depth at place = 0.5 k |place|^2
                            parameters: {k: 3 N/m}
                          - text: |
                              law fall
                                each body: energy = depth
                          - newton_motion
                        items:
                          - {name: bead, physical: {location: [2, 0, 0]}, physics: {mass: 1 kg}}
                        """);
        Outcome check = Reve.run("check", trap.toString(), "--strict");
        assertThat(check.code()).as(check.err()).isZero();
        Path saved = folder.resolve("saved.yaml");
        Outcome run =
                Reve.run("run", trap.toString(), "--seconds", "0.01", "--save", saved.toString());
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(speed(WorldFile.load(saved), "bead")).isCloseTo(-6.0 / 60, within(1e-15));
    }

    @Test
    void checkRefusesWrongDeclarationsAndTextsWithoutOne() throws Exception {
        String text = Files.readString(regatta);
        assertThat(refusal(text.replace("kind: world, type: field", "kind: body, type: field")))
                .contains(
                        "regatta.yaml:4:24: kind: found text `body`, expected world, because a"
                                + " field has one value at each place and no rows");
        assertThat(refusal(text.replace("components: 3", "components: 2")))
                .contains("field wind: found 2 components, expected 1 or 3");
        assertThat(refusal(text.replace("components: 3", "components: 3, min: 0")))
                .contains("min: laws only read a field, which a law library provides");
        assertThat(refusal(text.replace("name: wind", "name: forceField")))
                .contains("field forceField: each world has this field without a declaration");
        assertThat(refusal(text.replace("name: wind", "name: mass")))
                .contains("field mass: the name is already taken by a property of kind body");
        assertThat(refusal(text.replace("unit: m/s", "unit: N")))
                .contains("is a vector in m/s (a velocity), but 'wind' is N (a force)");
        assertThat(refusal(text.replaceAll("(?m)^properties:\\R.*\\R", "")))
                .contains("this world declares no field 'wind'");
        assertThat(refusal(text.replace("place.y, 0, 0)", "place.y, 0, 1 m/s^2 dt)")))
                .contains("but this one depends on 'dt'");
    }

    private String refusal(String text) throws Exception {
        Files.writeString(regatta, text);
        Outcome check = Reve.run("check", regatta.toString());
        assertThat(check.code()).as(check.out() + check.err()).isIn(3, 4);
        return check.err();
    }

    private static Outcome control(Server server, String... command) throws Exception {
        List<String> all = new ArrayList<>(List.of("control"));
        all.addAll(List.of(command));
        all.addAll(List.of("--port", server.port()));
        return Reve.run(all.toArray(String[]::new));
    }

    private static List<String> libraries(Server server, String list) throws Exception {
        return json(control(server, "laws"))
                .path(list)
                .valueStream()
                .map(entry -> entry.path("library").asString())
                .toList();
    }

    private Path law(String name) throws Exception {
        return Files.writeString(
                folder.resolve(name + ".law"),
                "law " + name + "\n  field wind at place = (0, 0, 1) m/s\n");
    }

    @Test
    void aProviderIsReplacedWhileTheWorldRunsAndALawWithoutItsFieldRests() throws Exception {
        try (Server server =
                Server.start(folder, "serve", regatta.toString(), "--port", "0", "--json")) {
            Outcome second = control(server, "load-law", "file=" + law("calm"));
            assertThat(second.code()).isEqualTo(1);
            assertThat(second.err()).contains("field wind comes from library breeze");
            assertThat(control(server, "load-law", "file=" + law("breeze")).code()).isZero();
            assertThat(libraries(server, "loaded")).contains("breeze", "sail");
            double across = 0;
            for (int i = 0; i < 100 && across < 0.5; i++) { // the boats follow the new wind
                across = velocity(server, "low", 2);
            }
            assertThat(across).isBetween(0.5, 1.0);
            assertThat(control(server, "unload-law", "library=breeze").code()).isZero();
            double resting = velocity(server, "low", 2);
            assertThat(velocity(server, "low", 2)).isEqualTo(resting).isBetween(0.5, 1.0);
            assertThat(libraries(server, "loaded")).containsExactly("sail", "newton_motion");
            assertThat(libraries(server, "quarantined")).isEmpty();
            assertThat(restingLaws(server)).containsExactly("sail");
            assertThat(control(server, "load-law", "file=" + law("calm")).code()).isZero();
            double again = resting;
            for (int i = 0; i < 100 && again == resting; i++) {
                again = velocity(server, "low", 2);
            }
            assertThat(again).isGreaterThan(resting);
            assertThat(restingLaws(server)).isEmpty();
        }
    }

    private static List<String> restingLaws(Server server) throws Exception {
        List<String> names = new ArrayList<>();
        for (JsonNode library : json(control(server, "laws")).get("loaded")) {
            for (JsonNode law : library.get("laws")) {
                if (law.path("resting").asBoolean(false)) {
                    names.add(law.get("name").asString());
                }
            }
        }
        return names;
    }

    private static double velocity(Server server, String item, int axis) throws Exception {
        JsonNode report = json(control(server, "inspect", "item=" + item));
        for (JsonNode property : report.get("physics")) {
            if (property.path("name").asString().equals("velocity")) {
                return property.get("value").get(axis).asDouble();
            }
        }
        throw new AssertionError(report.toString());
    }
}
