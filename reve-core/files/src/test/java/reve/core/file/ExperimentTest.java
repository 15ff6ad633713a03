// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.unit.Unit;
import reve.core.world.ItemDefinition;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.SortedMap;
import java.util.TreeMap;
import java.util.stream.IntStream;

/** The reader of experiments, with the runs and the worlds that they build from one world file. */
class ExperimentTest {
    private static final String HEAD =
            """
            experiment: 1
            name: e
            world: world.yaml
            seconds: 1
            """;
    private static final String SPEED =
            "measures: {speed: {of: ball, is: norm(physics.velocity)}}\n";

    @TempDir private Path folder;

    @BeforeEach
    void writeTheWorld() throws IOException {
        Files.writeString(
                folder.resolve("parts.yaml"),
                """
                prefabs:
                  round: {physical: {shape: sphere, radius: 1}}
                items:
                  - {name: part.one, like: round, physics: {mass: 5}}
                """);
        Files.writeString(
                folder.resolve("world.yaml"),
                """
                reve: 1
                name: w
                include: [parts.yaml]
                frame: {rate: 10}
                laws:
                  - gravity_field
                  - {name: drag, parameters: {wake: 2}}
                constants: {gravity: [0, -9.81, 0]}
                items:
                  - {name: ball, like: round, semantic: {hot: true}, physics: {mass: 1 kg}}
                  - name: dust-{i}
                    repeat: 3
                    physical: {location: "{ball(4)}"}
                    physics: {mass: 1 g}
                """);
    }

    private Experiment load(String text) throws Exception {
        return Experiment.load(Files.writeString(folder.resolve("e.yaml"), text));
    }

    private List<String> problems(String text) {
        return catchThrowableOfType(WorldFileException.class, () -> load(text)).problems().stream()
                .map(problem -> problem.toString().replace(folder + "/", ""))
                .toList();
    }

    private static ItemDefinition item(WorldDescription world, String name) {
        return world.items().stream().filter(item -> item.name().equals(name)).findFirst().get();
    }

    @Test
    void runsAreAllCombinationsOfCasesValuesAndSeeds() throws Exception {
        Experiment experiment =
                load(
                        HEAD
                                + """
                                seeds: [7, 9]
                                sweep:
                                  a: [1 km, 2 m]
                                  b: {from: 1, to: 100, count: 3, scale: log}
                                cases: {x: {}, y: {constants.gravity: [0, 0, 0]}}
                                """
                                + SPEED);
        assertThat(experiment.runs()).isEqualTo(2 * 2 * 3 * 2);
        assertThat(experiment.point(0).values()).isEqualTo(Map.of("a", 1000.0, "b", 1.0));
        assertThat(experiment.point(0).itsCase()).contains("x");
        assertThat(experiment.point(1).seed()).isEqualTo(9);
        assertThat(experiment.point(2).values().get("b")).isEqualTo(10.0);
        assertThat(experiment.point(23).values()).isEqualTo(Map.of("a", 2.0, "b", 100.0));
        assertThat(experiment.point(23).itsCase()).contains("y");
        assertThat(experiment.point(23).number()).isEqualTo(24);
        assertThat(experiment.plan(0).world().constants().get("gravity").get(1)).isEqualTo(-9.81);
        assertThat(experiment.plan(23).world().constants().get("gravity").get(1)).isZero();
    }

    @Test
    void pathsNameAnyValueOfTheWorldFileAndItsIncludedFiles() throws Exception {
        Experiment experiment =
                load(
                        HEAD.replace("seconds: 1", "seconds: \"{2 * x} s\"")
                                + """
                                sweep: {x: [3]}
                                set:
                                  frame.steps: "{x + 1}"
                                  laws.drag.parameters.wake: "{x}"
                                  laws.gravity_field.parameters.scale: 4
                                  items.ball.physics.mass: "{1000 * x} g"
                                  items.ball.semantic.hot: false
                                  items.part.one.physical.location: "{[x, 0, 1]}"
                                  items.dust-{i}.physics.mass: "{{(i + 1) * {x}}}"
                                  prefabs.round.physical.radius: 50 cm
                                """
                                + SPEED);
        RunPlan plan = experiment.plan(0);
        WorldDescription world = plan.world();
        assertThat(plan.frames()).isEqualTo(60);
        assertThat(world.timing().stepsPerFrame()).isEqualTo(4);
        assertThat(world.laws().get(1).parameters()).isEqualTo(Map.of("wake", 3.0));
        assertThat(world.laws().get(0).parameters()).isEqualTo(Map.of("scale", 4.0));
        assertThat(item(world, "ball").physics("mass").orElseThrow()).containsExactly(3);
        assertThat(item(world, "ball").symbols()).containsEntry("hot", false);
        assertThat(item(world, "part.one").location()).containsExactly(3, 0, 1);
        assertThat(item(world, "dust-2").physics("mass").orElseThrow()).containsExactly(9);
        assertThat(item(world, "ball").shape().size(0)).isEqualTo(1.0);
        assertThat(experiment.inputs()).containsOnlyKeys("e.yaml", "world.yaml", "parts.yaml");
    }

    @Test
    void theSeedChangesTheRandomNumbersOfTheWorldFileAndSeedZeroDoesNot() throws Exception {
        Experiment experiment = load(HEAD + "seeds: 3\n" + SPEED);
        WorldDescription alone = WorldFile.load(folder.resolve("world.yaml"));
        List<List<Double>> places = new ArrayList<>();
        for (int run = 0; run < 3; run++) {
            double[] at = item(experiment.plan(run).world(), "dust-1").location();
            places.add(List.of(at[0], at[1], at[2]));
        }
        assertThat(places).doesNotHaveDuplicates();
        assertThat(item(alone, "dust-1").location())
                .containsExactly(places.getFirst().stream().mapToDouble(x -> x).toArray());
    }

    @Test
    void aWrongValueIsReportedAtItsLineInTheExperiment() {
        assertThat(
                        problems(
                                HEAD
                                        + """
                                        set:
                                          items.ball.physics.mass: 3 m
                                          items.ball.physics.masss: 3 kg
                                          frame.rate: -1
                                        """
                                        + SPEED))
                .containsExactly(
                        "e.yaml:6:28: mass: unit m does not fit kg",
                        "e.yaml:7:3: unknown physics property `masss` of kind body; did you mean"
                                + " `mass`?",
                        "e.yaml:8:15: rate: found number -1, expected at least 1");
        assertThat(problems(HEAD + "set: {items.ball.physics.mass: 3 m}\n" + SPEED))
                .containsExactly("e.yaml:5:32: mass: unit m does not fit kg");
        assertThat(problems(HEAD + "set: {items.ball.physics.masss: 3 kg}\n" + SPEED))
                .containsExactly(
                        "e.yaml:5:7: unknown physics property `masss` of kind body; did you mean"
                                + " `mass`?");
        assertThat(problems(HEAD + "set: {items.bal.physics.mass: 3 kg}\n" + SPEED))
                .containsExactly(
                        "e.yaml:5:7: `items.bal.physics.mass`: items of the world file contain no"
                                + " `bal`; did you mean `ball`?");
        assertThat(problems(HEAD + "set: {frame.rate.x: 3}\n" + SPEED))
                .containsExactly(
                        "e.yaml:5:7: `frame.rate.x`: `rate` is number 10 in the world file, which"
                                + " has no keys");
        assertThat(problems(HEAD + "set: {include: []}\n" + SPEED)).hasSize(1);
    }

    @Test
    void mistakesInTheExperimentAreReportedWithTheirPlace() {
        assertThat(problems(HEAD + "sweeps: {a: [1]}\n" + SPEED))
                .containsExactly("e.yaml:5:1: unknown key `sweeps`; did you mean `sweep`?");
        assertThat(
                        problems(
                                HEAD
                                        + """
                                        measures:
                                          a: {of: bal, is: physics.mass}
                                          b: {of: ball, is: physics.maß}
                                          c: {of: ball, sum: body, is: physics.mass}
                                          d: {ledger: total.enrgy}
                                          e: {energy: kinetic, take: mean}
                                          f: {sum: body, is: item.name}
                                          g: {of: ball}
                                        """))
                .hasSize(7)
                .anyMatch(
                        line ->
                                line.equals(
                                        "e.yaml:6:11: of: no item is named `bal`; did you mean"
                                                + " `ball`?"))
                .anyMatch(line -> line.startsWith("e.yaml:9:15: ledger: found `total.enrgy`"))
                .anyMatch(line -> line.contains("did you mean `energy`?"))
                .anyMatch(line -> line.startsWith("e.yaml:10:30: take: "));
        assertThat(problems(HEAD + "sweep: {a: [1 m, 2 kg]}\n" + SPEED))
                .containsExactly("e.yaml:5:18: a[1]: unit kg does not fit m");
        assertThat(problems(HEAD + "sweep: {sin: [1]}\n" + SPEED))
                .containsExactly(
                        "e.yaml:5:9: `sin` means something else in formulas; choose another name");
        assertThat(problems(HEAD + "set: {frame.steps: \"{b}\"}\nsweep: {a: [1]}\n" + SPEED))
                .singleElement()
                .asString()
                .startsWith("e.yaml:5:20: frame.steps: formula `b` ");
        assertThat(problems(HEAD.replace("world.yaml", "../world.yaml") + SPEED))
                .singleElement()
                .asString()
                .startsWith("e.yaml:3:8: world: ../world.yaml: expected a path within");
    }

    @Test
    void theNumberOfRunsAndValuesIsLimited() {
        String many = "{from: 0, to: 1, count: 1000}";
        assertThat(problems(HEAD + "sweep: {a: " + many + ", b: " + many + "}\n" + SPEED))
                .singleElement()
                .asString()
                .contains("found 1000000 combinations");
        assertThat(
                        problems(
                                HEAD.replace("seconds: 1", "seconds: 100000")
                                        + "sweep: {a: "
                                        + many
                                        + "}\nevery: 1\n"
                                        + SPEED))
                .singleElement()
                .asString()
                .contains("every: all runs measure about ");
        assertThat(problems(HEAD.replace("seconds: 1", "seconds: 1e30") + SPEED))
                .singleElement()
                .asString()
                .startsWith("e.yaml:4:10: seconds: are ");
    }

    @Test
    void changesOfLawsBelongToFrames() throws Exception {
        RunPlan plan =
                load(HEAD
                                + """
                                        sweep: {k: [3]}
                                        schedule:
                                          - {frame: 9, unload: drag}
                                          - {at: 300 ms, set: drag, parameters: {wake: "{2 * k}"}}
                                          - {at: 0.31 s, load: coulomb}
                                          - {at: 0 s, text: "law w: {no formula}"}
                                        """
                                + SPEED)
                        .plan(0);
        assertThat(plan.steps()).extracting(LawStep::frame).containsExactly(1L, 4L, 5L, 9L);
        assertThat(plan.steps().get(0).law().name()).isEqualTo("w");
        assertThat(plan.steps().get(0).law().text()).contains("law w: {no formula}");
        assertThat(plan.steps().get(1).law().parameters()).isEqualTo(Map.of("wake", 6.0));
        assertThat(problems(HEAD + "schedule: [{at: 2 s, load: drag}]\n" + SPEED))
                .containsExactly("e.yaml:5:17: at: is in frame 21, and the run has frames 1 to 10");
        assertThat(problems(HEAD + "schedule: [{at: 0, load: drag, unload: drag}]\n" + SPEED))
                .containsExactly(
                        "e.yaml:5:12: schedule[0]: found load and unload, expected one of load,"
                                + " unload, set, text");
    }

    @Test
    void agentsNeedABodyAndGetFormulasInTheirCommands() throws Exception {
        String agents =
                "sweep: {k: [3]}\nagents: {ada: {command: [run, \"{k}\", \"--port={port}\"]}}\n";
        assertThat(problems(HEAD + agents + SPEED))
                .containsExactly(
                        "e.yaml:6:9: agents: the world file grants agents no body, so none can"
                                + " join; see the key `agents` of world files");
        RunPlan plan = load(HEAD + agents + "set: {agents.bodies: [ball]}\n" + SPEED).plan(0);
        assertThat(plan.agents().getFirst().command(77)).containsExactly("run", "3", "--port=77");
    }

    @Test
    void anExpectedValueFollowsFromTheRun() throws Exception {
        Experiment experiment =
                load(
                        HEAD
                                + """
                                sweep: {k: [3, 4]}
                                measures:
                                  m: {of: ball, is: physics.mass, expected: "{k / 2} kg", tolerance: 2 %}
                                """);
        Measure measure = experiment.plan(1).measures().getFirst();
        assertThat(measure.expected()).hasValue(2);
        assertThat(measure.tolerance()).hasValue(0.02);
        assertThatThrownBy(() -> load(HEAD + "measures: {m: {energy: total, tolerance: 1 %}}\n"))
                .hasMessageContaining("`expected` is missing");
    }

    @Test
    void unitsFollowFromTheFileAndFromExpressions() throws Exception {
        Experiment experiment =
                load(
                        HEAD
                                + """
                                sweep: {a: [3 g, 4 g], b: [10 deg, 20 deg], c: [1, 2]}
                                every: 1
                                measures:
                                  speed: {of: ball, is: norm(physics.velocity)}
                                  fast: {of: ball, is: norm(physics.velocity), unit: km/h}
                                  swing: {of: ball, is: "physics.velocity[1]", take: period}
                                  weight: {of: ball, is: 9.81 * physics.mass, expected: 3 kN}
                                  product: {of: ball, is: 9.81 * physics.mass}
                                  total: {energy: total, unit: kJ}
                                  push: {ledger: total.momentum}
                                """);
        assertThat(List.of("a", "b", "c"))
                .extracting(name -> experiment.variableUnit(name).map(Unit::symbol).orElse("-"))
                .containsExactly("kg", "rad", "-");
        assertThat(IntStream.range(0, 7).boxed())
                .extracting(i -> experiment.measurementUnit(i).map(Unit::symbol).orElse("-"))
                .containsExactly("m/s", "km/h", "m/s", "kg*m/s^2", "-", "kJ", "kg*m/s");
        assertThat(IntStream.range(0, 7).boxed())
                .extracting(i -> experiment.valueUnit(i).map(Unit::symbol).orElse("-"))
                .containsExactly("m/s", "km/h", "s", "kg*m/s^2", "-", "kJ", "kg*m/s");
    }

    @Test
    void aUnitThatDoesNotFitIsReportedAtItsPlace() {
        assertThat(
                        problems(
                                HEAD
                                        + """
                                        every: 1
                                        measures:
                                          a: {of: ball, is: physics.mass, unit: km}
                                          b: {of: ball, is: physics.mass, unit: glow}
                                          c: {energy: kinetic, expected: 3 N}
                                          d: {of: ball, is: physics.mass, take: period, expected: 1 kg}
                                        """))
                .hasSize(4)
                .contains(
                        "e.yaml:7:41: unit: unit km does not fit the measured value, which is in"
                                + " kg",
                        "e.yaml:9:34: expected: unit N does not fit the measured value, which is"
                                + " in J",
                        "e.yaml:10:59: expected: unit kg does not fit the measured value, which"
                                + " is in s")
                .anyMatch(line -> line.startsWith("e.yaml:8:41: unit: unit `glow`"));
    }

    @Test
    void thePackOfAWorldIsReadFromTheFolderOfItsFiles() throws Exception {
        Path unpacked = Files.createDirectory(folder.resolve("unpacked"));
        Path pack = folder.resolve("w.reve");
        SortedMap<String, Path> files = new TreeMap<>();
        files.put("world.yaml", folder.resolve("world.yaml"));
        files.put("parts.yaml", folder.resolve("parts.yaml"));
        WorldPack.write(pack, files);
        Path file =
                Files.writeString(
                        folder.resolve("e.yaml"), HEAD.replace("world.yaml", "w.reve") + SPEED);
        Experiment experiment =
                Experiment.load(
                        file,
                        found -> {
                            assertThat(found.getFileName()).hasToString("w.reve");
                            WorldPack.unpack(found, unpacked);
                            return unpacked;
                        });
        WorldDescription packed = experiment.plan(0).world();
        WorldDescription plain = load(HEAD + SPEED).plan(0).world();
        assertThat(packed.items())
                .extracting(ItemDefinition::name)
                .containsExactlyElementsOf(
                        plain.items().stream().map(ItemDefinition::name).toList());
        assertThat(packed.constants()).isEqualTo(plain.constants());
        assertThat(experiment.worldFolder()).isEqualTo(unpacked);
        assertThat(experiment.inputs()).containsOnlyKeys("e.yaml", "w.reve");
        assertThatThrownBy(() -> load(HEAD.replace("world.yaml", "w.reve") + SPEED))
                .hasMessageContaining("e.yaml:3:8: world: ")
                .hasMessageContaining("is a pack, expected a world file");
    }

    @Test
    void filesThatCommandsOfAgentsNameAreInputs() throws Exception {
        Files.createDirectory(folder.resolve("bots"));
        Files.writeString(folder.resolve("bots/one.py"), "");
        Files.writeString(folder.resolve("bots/2.py"), "");
        String agents =
                "agents: {ada: {command: [python3, bots/one.py, \"bots/{run + 1}.py\", /etc/passwd,"
                        + " ../x, bots]}}\nset: {agents.bodies: [ball]}\nsweep: {k: [1, 2]}\n";
        Experiment experiment = load(HEAD + agents + SPEED);
        assertThat(experiment.inputs())
                .containsOnlyKeys("e.yaml", "world.yaml", "parts.yaml", "bots/one.py", "bots/2.py");
        assertThat(experiment.findInput("bots/one.py")).hasValue(folder.resolve("bots/one.py"));
        assertThat(experiment.findInput("../x")).isEmpty();
        assertThat(experiment.findInput("bots/3.py")).isEmpty();
        Files.writeString(folder.resolve("bots/3.py"), "");
        experiment.addInput("bots/3.py");
        assertThat(experiment.inputs()).containsKey("bots/3.py");
    }
}
