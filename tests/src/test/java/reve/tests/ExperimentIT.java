// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.stream.Stream;

/**
 * The examples of the page about the command {@code experiment}, and comparisons with earlier
 * results.
 */
class ExperimentIT {
    @TempDir private Path folder;
    private Document page;

    @BeforeEach
    void writeTheFilesOfThePage() throws IOException {
        page = Document.read(Project.ROOT.resolve("docs/experiments.md"));
        for (Document.Block block : page.blocks()) {
            if (block.title().endsWith(".yaml") || block.title().endsWith(".py")) {
                Files.writeString(folder.resolve(block.title()), block.text());
            }
        }
    }

    /** Runs a command line of the page in the folder of its files. */
    private Outcome script(String title, String... more) throws Exception {
        String line = page.titled(title).text().strip();
        assertThat(line).startsWith("\"$REVE/reve\" experiment ");
        List<String> words = new ArrayList<>();
        for (String word : line.substring("\"$REVE/reve\" ".length()).split(" ")) {
            boolean file =
                    word.endsWith(".yaml") || !words.isEmpty() && words.getLast().equals("--out");
            words.add(file ? folder.resolve(word).toString() : word);
        }
        words.addAll(List.of(more));
        return Reve.run(words.toArray(String[]::new));
    }

    private Outcome experiment(String file, String out, String... more) throws Exception {
        return Reve.run(
                Stream.concat(
                                Stream.of(
                                        "experiment",
                                        folder.resolve(file).toString(),
                                        "--out",
                                        folder.resolve(out).toString(),
                                        "--engine",
                                        "in-process"),
                                Stream.of(more))
                        .toArray(String[]::new));
    }

    private List<String> lines(String file) throws IOException {
        return Files.readAllLines(folder.resolve(file));
    }

    /** Returns the cells of each row of a table, without its header. */
    private List<List<String>> rows(String file) throws IOException {
        return lines(file).stream().skip(1).map(line -> List.of(line.split(",", -1))).toList();
    }

    @Test
    void theExampleOfThePagePrintsItsTableAndTheSameAgain() throws Exception {
        Outcome first = script("run.sh");
        assertThat(first.code()).as(first.err()).isZero();
        assertThat(first.out()).startsWith(page.titled("printed").text());
        assertThat(folder.resolve("results/speed-over-mass.png")).isNotEmptyFile();
        assertThat(folder.resolve("results/depth-over-time.png")).isNotEmptyFile();
        assertThat(
                        new JsonMapper()
                                .readTree(Files.readString(folder.resolve("results/result.json")))
                                .path("units"))
                .hasToString("{\"c\":\"kg/s\",\"mass\":\"kg\",\"speed\":\"m/s\",\"depth\":\"m\"}");
        for (List<String> row : rows("results/runs.csv")) {
            double drag = Double.parseDouble(row.get(1));
            double mass = Double.parseDouble(row.get(2));
            double speed = mass * 9.81 / drag * (1 - Math.exp(-drag * 2 / mass));
            assertThat(Double.parseDouble(row.get(5))).isCloseTo(speed, within(1e-3 * speed));
        }

        Outcome again = script("run.sh", "--jobs", "1", "--engine", "in-process");

        assertThat(again.code()).as(again.out()).isZero();
        assertThat(again.out().replace(folder + "/", "")).endsWith(page.titled("again").text());
    }

    @Test
    void theFirstDifferenceIsNamedWithBothValuesAndWhatChangedSince() throws Exception {
        assertThat(experiment("sinking.yaml", "r").code()).isZero();
        List<String> series = new ArrayList<>(lines("r/series.csv"));
        int at = 0;
        while (!series.get(at).startsWith("5,60,")) {
            at++;
        }
        List<String> cells = new ArrayList<>(List.of(series.get(at).split(",")));
        String speed = cells.get(3);
        cells.set(3, "0.25");
        series.set(at, String.join(",", cells));
        Files.write(folder.resolve("r/series.csv"), series);
        Path meta = folder.resolve("r/result.json");
        Files.writeString(
                meta,
                Files.readString(meta)
                        .replaceFirst("\"version\" : \"[^\"]*", "\"version\" : \"0.9"));

        Outcome changed = experiment("sinking.yaml", "r", "--json");

        assertThat(changed.code()).as(changed.err()).isEqualTo(1);
        JsonNode result = new JsonMapper().readTree(changed.out());
        assertThat(result.path("identical").asBoolean(true)).isFalse();
        JsonNode difference = result.path("difference");
        assertThat(difference.path("run").asString()).isEqualTo("run 5 (c = 2, mass = 0.05)");
        assertThat(difference.path("frame").asInt()).isEqualTo(60);
        assertThat(difference.path("measure").asString()).isEqualTo("speed");
        assertThat(difference.path("before").asString()).isEqualTo("0.25");
        assertThat(difference.path("now").asString()).isEqualTo(speed);
        assertThat(result.path("since").get(0).asString())
                .startsWith("made by version 0.9, this is");
        assertThat(lines("r/series.csv")).isEqualTo(series);
        assertThat(lines("r/changed/series.csv")).hasSameSizeAs(series).isNotEqualTo(series);

        Outcome replaced = experiment("sinking.yaml", "r", "--replace");
        assertThat(replaced.code()).as(replaced.err()).isZero();
        assertThat(lines("r/series.csv")).isEqualTo(lines("r/changed/series.csv"));
    }

    @Test
    void aChangedWorldDiffersInItsFirstMeasurementAndIsNamed() throws Exception {
        assertThat(experiment("sinking.yaml", "r").code()).isZero();
        Path world = folder.resolve("syrup.yaml");
        Files.writeString(world, Files.readString(world).replace("-9.81", "-9.8"));

        Outcome changed = experiment("sinking.yaml", "r");

        assertThat(changed.code()).isEqualTo(1);
        assertThat(changed.out())
                .contains("different: run 1 (c = 1, mass = 0.05): in frame 6 speed was 0.")
                .contains("since those results: the file syrup.yaml has changed");
        Outcome other = experiment("cases.yaml", "r");
        assertThat(other.code()).isEqualTo(2);
        assertThat(other.err()).contains("contains the results of the experiment sinking");
    }

    @Test
    void aFailedRunCostsOnlyItself() throws Exception {
        Path file = folder.resolve("sinking.yaml");
        Files.writeString(
                file,
                Files.readString(file)
                        .replace("[1 kg/s, 2 kg/s]", "[1 kg/s]")
                        .replace(
                                "{from: 50 g, to: 400 g, count: 4, scale: log}",
                                "[100 g, 200 g, -1 g, 400 g]"));

        Outcome outcome = experiment("sinking.yaml", "r");

        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.messages())
                .contains("reve: run 3 failed: " + file + ":9:28: mass: ")
                .hasLineCount(1);
        assertThat(rows("r/runs.csv"))
                .extracting(row -> row.get(10))
                .containsExactly("ok", "ok", "failed", "ok");
    }

    @Test
    void aValueOutsideOfItsToleranceFails() throws Exception {
        Path file = folder.resolve("sinking.yaml");
        Files.writeString(file, Files.readString(file).replace("seconds: 2", "seconds: 0.2"));

        Outcome outcome = experiment("sinking.yaml", "r");

        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.out()).contains("run 4: speed is 1.569").contains(", expected 3.924");
    }

    @Test
    void seedsChangeRunsInTheSameWayInEachCase() throws Exception {
        Outcome outcome = experiment("cases.yaml", "r", "--jobs", "3");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        List<List<String>> rows = rows("r/runs.csv");
        assertThat(rows)
                .extracting(row -> row.get(1) + row.get(2))
                .containsExactly("euler0", "euler1", "euler2", "verlet0", "verlet1", "verlet2");
        assertThat(rows).extracting(row -> row.get(4)).doesNotHaveDuplicates();
        assertThat(rows).extracting(row -> row.get(5)).doesNotHaveDuplicates();
        for (int seed = 0; seed < 3; seed++) {
            double euler = Double.parseDouble(rows.get(seed).get(4));
            assertThat(Double.parseDouble(rows.get(seed + 3).get(4)))
                    .isCloseTo(euler, within(0.02 * euler));
        }
    }

    /**
     * The wind has 5 m/s and a drag of c. The air at rest has a drag of 1 kg/s. Then v becomes 5 c
     * / (c + 1).
     */
    @Test
    void lawsChangeAtTheirTimes() throws Exception {
        Outcome outcome = experiment("schedule.yaml", "r");
        assertThat(outcome.code()).as(outcome.err()).isZero();
        List<List<String>> rows = rows("r/series.csv");
        double[] c = {0.5, 1};
        for (int run = 1; run <= 2; run++) {
            assertThat(speed(rows, run, 60)).isZero();
            assertThat(speed(rows, run, 120))
                    .isCloseTo(5 * c[run - 1] / (c[run - 1] + 1), within(1e-3));
            assertThat(speed(rows, run, 180)).isCloseTo(50.0 / 11, within(1e-3));
        }
        Path file = folder.resolve("schedule.yaml");
        Files.writeString(file, Files.readString(file).replace("set: wind", "set: wnd"));
        Outcome refused = experiment("schedule.yaml", "s");
        assertThat(refused.code()).isEqualTo(1);
        assertThat(refused.err()).contains(file + ":15:5: no law \"wnd\" is loaded");
    }

    private static double speed(List<List<String>> rows, int run, int frame) {
        return rows.stream()
                .filter(row -> row.get(0).equals("" + run) && row.get(1).equals("" + frame))
                .mapToDouble(row -> Double.parseDouble(row.get(3)))
                .findFirst()
                .orElseThrow();
    }

    @Test
    void agentsArePermittedByTrustAndActInTheSameFramesEachTime() throws Exception {
        Outcome untrusted = experiment("agents.yaml", "pushed");
        assertThat(untrusted.code()).isEqualTo(2);
        assertThat(untrusted.err()).contains("names programs of agents (ada)").contains("--trust");
        assertThat(folder.resolve("pushed")).doesNotExist();

        Outcome first = script("agents.sh");
        assertThat(first.code()).as(first.err()).isZero();
        assertThat(rows("pushed/series.csv"))
                .extracting(row -> String.join(",", row))
                .containsExactly(
                        "1,0,0,0", "1,30,0.5,5", "1,60,1,5", "2,0,0,0", "2,30,0.5,10", "2,60,1,10");
        assertThat(lines("pushed/agents/run-2-ada.log")).hasSize(10);

        Outcome again = script("agents.sh", "--jobs", "2");
        assertThat(again.out()).contains("identical to the results in ");

        Path result = folder.resolve("pushed/result.json");
        String text = Files.readString(result);
        Files.writeString(result, text.replaceFirst("(\"stateHash\" : \")[0-9a-f]{4}", "$1beef"));
        Outcome changed = script("agents.sh");
        assertThat(changed.code()).isEqualTo(1);
        assertThat(changed.out()).contains("different: run 1 in result.json: stateHash was \"beef");
        Files.delete(result);
        Files.createSymbolicLink(result, Path.of("/dev/zero"));
        Outcome linked = script("agents.sh");
        assertThat(linked.code()).isEqualTo(2);
        assertThat(linked.err()).contains("result.json", "found a symbolic link");
    }

    @Test
    void anAgentThatFailsOrWaitsForNoFrameFailsItsRun() throws Exception {
        Path program = folder.resolve("pusher.py");
        String text = Files.readString(program);
        Files.writeString(
                program,
                "import sys\nif sys.argv[1] == '1': sys.exit('no idea')\n"
                        + text.replace("agent.observe()", "agent.perceive()")
                                .replace("reve.LockStep(deadline=60)", "None"));

        Outcome outcome = experiment("agents.yaml", "r", "--trust");

        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err())
                .contains("run 1 failed: 0 of 1 agents are in lock-step, expected all")
                .contains(
                        "run 2 failed: the program of agent ada ended with code 1 (no idea) before"
                                + " it had joined");
    }

    @Test
    void theShippedPendulumsSwingAsTheClosedFormSays() throws Exception {
        Outcome outcome =
                Reve.run(
                        "experiment",
                        Project.WORLDS.resolve("pendulum").toString(),
                        "--out",
                        folder.resolve("p").toString());
        assertThat(outcome.code()).as(outcome.out() + outcome.err()).isZero();
        assertThat(rows("p/runs.csv")).hasSize(10);
    }

    /**
     * The handle flips during the run. Therefore the energy is correct only if the inertia is used
     * along the handle's own axes.
     */
    @Test
    void kineticEnergyIsThatOfAFreelyRotatingBody() throws Exception {
        for (String file : List.of("world.yaml", "handle.glb", "crate.png")) {
            Files.copy(Project.WORLDS.resolve("t-handle").resolve(file), folder.resolve(file));
        }
        String energy = "{energy: kinetic, expected: 0.5186, tolerance: 0.02 %, take: ";
        Files.writeString(
                folder.resolve("turning.yaml"),
                """
                experiment: 1
                name: turning
                world: world.yaml
                seconds: 3
                every: 5
                measures:
                """
                        + "  least: "
                        + energy
                        + "min}\n  most: "
                        + energy
                        + "max}\n");
        Outcome outcome = experiment("turning.yaml", "t");
        assertThat(outcome.code()).as(outcome.out() + outcome.err()).isZero();
    }

    @Test
    void aLineThatTheLedgerLacksIsNamedWithASimilarOne() throws Exception {
        Path file = folder.resolve("cases.yaml");
        Files.writeString(
                file,
                Files.readString(file)
                        .replace("seeds: 3\n", "")
                        .replace("{energy: kinetic}", "{ledger: velocity_verle.energy}"));
        Outcome outcome = experiment("cases.yaml", "r");
        assertThat(outcome.code()).isEqualTo(1);
        assertThat(outcome.err())
                .contains("run 2 failed: " + file + ":11:3: ledger: there is no line")
                .contains("did you mean `velocity_verlet`?");
    }

    @Test
    void aFileIsCheckedWithoutARun() throws Exception {
        Outcome checked =
                Reve.run("experiment", folder.resolve("sinking.yaml").toString(), "--dry-run");
        assertThat(checked.code()).as(checked.err()).isZero();
        assertThat(checked.out()).contains("valid, 8 runs, 2 measures");
        Path file = folder.resolve("wrong.yaml");
        Files.writeString(
                file,
                Files.readString(folder.resolve("sinking.yaml")).replace("take", "x")
                        + "seed: 3\n");
        Outcome wrong = experiment("wrong.yaml", "r");
        assertThat(wrong.code()).isEqualTo(3);
        assertThat(wrong.err()).contains("unknown key `seed`; did you mean `seeds`?");
        Files.writeString(folder.resolve("mine.txt"), "");
        Outcome foreign = experiment("sinking.yaml", ".");
        assertThat(foreign.code()).isEqualTo(2);
        assertThat(foreign.err()).contains("contains files and no results of an experiment");
    }
}
