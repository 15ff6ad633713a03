// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.TimeUnit;
import java.util.stream.Stream;

/**
 * Experiments whose process is killed. The program of the agent writes the number of each run that
 * it starts, and waits in run 3 until a file exists.
 */
@Tag("slow")
class ExperimentResumeIT {
    private static final int PATIENCE_SECONDS = 300;
    private static final String JOURNAL = "unfinished.jsonl";

    @TempDir private Path folder;

    @BeforeEach
    void writeTheExperiment() throws IOException {
        Document page = Document.read(Project.ROOT.resolve("docs/experiments.md"));
        Files.writeString(folder.resolve("balls.yaml"), page.titled("balls.yaml").text());
        Files.writeString(
                folder.resolve("slow.py"),
                """
                import os, sys, time
                with open("starts", "a") as starts:
                    starts.write(os.environ["REVE_RUN"] + "\\n")
                for _ in range(2400):
                    if os.environ["REVE_RUN"] != "3" or os.path.exists("go"):
                        break
                    time.sleep(0.05)
                """
                        + page.titled("pusher.py").text());
        Files.writeString(
                folder.resolve("kept.yaml"),
                """
                experiment: 1
                name: kept
                world: balls.yaml
                seconds: 0.5
                sweep: {strength: [1, 2, 3, 4]}
                agents:
                  ada: {command: [python3, slow.py, "{strength}"]}
                every: 15
                measures:
                  speed:
                    of: ball
                    is: "physics.velocity[0]"
                    expected: "{10 * strength} m/s"
                    tolerance: 1e-9
                """);
    }

    private String[] command(String out) {
        return new String[] {
            "experiment",
            folder.resolve("kept.yaml").toString(),
            "--out",
            folder.resolve(out).toString(),
            "--jobs",
            "1",
            "--trust",
            "--engine",
            "in-process"
        };
    }

    private Outcome experiment(String out) throws InterruptedException {
        return Reve.run(
                Stream.concat(Stream.of(command(out)), Stream.of("--json")).toArray(String[]::new));
    }

    private List<String> starts() throws IOException {
        Path file = folder.resolve("starts");
        return Files.exists(file) ? Files.readAllLines(file) : List.of();
    }

    private List<String> files(String out) throws IOException {
        try (Stream<Path> files = Files.list(folder.resolve(out))) {
            return files.map(file -> file.getFileName().toString()).sorted().toList();
        }
    }

    private static JsonNode json(Outcome outcome) {
        return new JsonMapper().readTree(outcome.out());
    }

    /** Starts the experiment, whose output is the file printed.txt. */
    private Process start(String out) throws IOException {
        return new ProcessBuilder(Reve.command(command(out)))
                .redirectErrorStream(true)
                .redirectOutput(folder.resolve("printed.txt").toFile())
                .start();
    }

    private void requireAlive(Process process) throws IOException {
        assertThat(process.isAlive()).as(Files.readString(folder.resolve("printed.txt"))).isTrue();
    }

    /** Starts the experiment and kills it while run 3 waits. */
    private void kill(String out) throws Exception {
        Process process = start(out);
        try {
            awaitRun3(process);
            Outcome second = experiment(out);
            assertThat(second.code()).isEqualTo(1);
            assertThat(second.err())
                    .contains(JOURNAL + ": another command writes results into this folder");
        } finally {
            process.destroyForcibly().waitFor();
        }
    }

    private void awaitRun3(Process process) throws Exception {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (!starts().contains("3")) {
            requireAlive(process);
            assertThat(System.nanoTime()).isLessThan(end);
            Thread.sleep(20);
        }
    }

    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void aKilledExperimentContinuesAfterItsFinishedRuns() throws Exception {
        kill("r");
        assertThat(files("r")).containsExactly("agents", JOURNAL);
        copyJournal("r", "changed-world");
        copyJournal("r", "changed-program");

        // A process may be killed while it writes a line of the journal, or the tables.
        Files.writeString(
                folder.resolve("r").resolve(JOURNAL),
                "01234567 {\"run\":",
                StandardOpenOption.APPEND);
        Files.writeString(folder.resolve("r/runs.csv"), "run,strength\n1,");
        Files.writeString(folder.resolve("r/series.csv.part"), "run,");
        Files.writeString(folder.resolve("go"), "");
        Outcome continued = experiment("r");

        assertThat(continued.code()).as(continued.err()).isZero();
        assertThat(continued.err())
                .contains("continues after 2 of 4 runs, which an earlier command has made");
        assertThat(json(continued).path("continued").asInt()).isEqualTo(2);
        assertThat(json(continued).path("runs")).hasSize(4);
        assertThat(starts()).containsExactly("1", "2", "3", "3", "4");
        assertThat(files("r")).doesNotContain(JOURNAL, "series.csv.part");

        Path temporary = Files.createDirectory(folder.resolve("temporary"));
        List<String> apart = new ArrayList<>(Reve.command(command("whole")));
        apart.add("--json");
        apart.add(2, "JAVA_TOOL_OPTIONS=-Djava.io.tmpdir=" + temporary);
        Outcome whole = Reve.run(apart);
        try (Stream<Path> left = Files.list(temporary)) {
            assertThat(left).as("files of the experiment that remain").isEmpty();
        }
        assertThat(whole.code()).as(whole.err()).isZero();
        assertThat(json(whole).path("continued").asInt(-1)).isZero();
        for (String file : List.of("runs.csv", "series.csv", "result.json")) {
            assertThat(folder.resolve("r").resolve(file))
                    .hasSameBinaryContentAs(folder.resolve("whole").resolve(file));
        }
        assertThat(files("r")).isEqualTo(files("whole"));

        Files.writeString(
                folder.resolve("slow.py"), "\nprint('changed')\n", StandardOpenOption.APPEND);
        Outcome program = experiment("changed-program");
        assertThat(program.err())
                .contains("begins with the first run")
                .contains("slow.py has changed");
        assertThat(json(program).path("continued").asInt(-1)).isZero();
        Path world = folder.resolve("balls.yaml");
        Files.writeString(world, Files.readString(world).replace("mass: 1 kg", "mass: 2 kg"));
        Outcome changed = experiment("changed-world");
        assertThat(changed.code()).isEqualTo(1);
        assertThat(changed.err())
                .contains("begins with the first run")
                .contains("the file balls.yaml has changed");
        assertThat(json(changed).path("runs"))
                .extracting(run -> run.path("values").path("speed").asDouble())
                .containsExactly(5.0, 10.0, 15.0, 20.0);
    }

    /** Results are complete, with their plots, or do not count as results. */
    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void anExperimentThatEndsWhileItWritesItsResultsWritesThemAgain() throws Exception {
        Files.writeString(folder.resolve("go"), "");
        Process process = start("r");
        try {
            while (!Files.exists(folder.resolve("r/runs.csv"))) {
                requireAlive(process);
                Thread.sleep(1);
            }
            process.destroy(); // SIGTERM
            int code = process.waitFor();
            boolean whole = Files.exists(folder.resolve("r/result.json"));
            assertThat(code)
                    .as(Files.readString(folder.resolve("printed.txt")))
                    .isEqualTo(whole ? 0 : 130);
            if (whole) {
                assertThat(files("r")).contains("speed-over-strength.png");
            }
        } finally {
            process.destroyForcibly().waitFor();
        }
        Outcome again = experiment("r");
        assertThat(again.code()).as(again.err()).isZero();
        assertThat(files("r")).contains("speed-over-strength.png", "result.json");
    }

    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void anExperimentThatIsInterruptedBeforeItsFirstRunEndsAsCut() throws Exception {
        Process process = start("r");
        try {
            while (!Files.isDirectory(folder.resolve("r"))) {
                requireAlive(process);
                Thread.onSpinWait();
            }
            process.destroy(); // SIGTERM
            assertThat(process.waitFor()).isEqualTo(130);
        } finally {
            process.destroyForcibly().waitFor();
        }
    }

    /** The table is kept if the disk is full when the plots are written. */
    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void aPlotThatCannotBeWrittenIsNamedWithTheReason() throws Exception {
        Path file = folder.resolve("kept.yaml");
        Files.writeString(file, Files.readString(file).replace("[1, 2, 3, 4]", "[1, 2, 3]"));
        Process process = start("r");
        try {
            awaitRun3(process);
            // The tables are smaller than this limit, the plots are larger.
            Outcome limited =
                    Reve.run(List.of("prlimit", "--pid", process.pid() + "", "--fsize=16384"));
            assertThat(limited.code()).as(limited.err()).isZero();
            Files.writeString(folder.resolve("go"), "");
            int code = process.waitFor();
            String printed = Files.readString(folder.resolve("printed.txt"));
            assertThat(code).as(printed).isEqualTo(1);
            assertThat(printed)
                    .contains("-over-strength.png", "File too large")
                    .doesNotContain("\tat ", "IIOException");
            assertThat(Files.readAllLines(folder.resolve("r/runs.csv"))).hasSize(4);
        } finally {
            process.destroyForcibly().waitFor();
        }
        Outcome again = experiment("r");
        assertThat(again.code()).as(again.err()).isZero();
        assertThat(files("r")).contains("speed-over-strength.png", "result.json");
    }

    private void copyJournal(String from, String to) throws IOException {
        Files.copy(
                folder.resolve(from).resolve(JOURNAL),
                Files.createDirectory(folder.resolve(to)).resolve(JOURNAL));
    }

    /** A comparison repeats all runs. If it is killed, a later command continues it. */
    @Test
    @Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
    void aKilledComparisonContinuesAndLeavesTheEarlierResults() throws Exception {
        Files.writeString(folder.resolve("go"), "");
        Outcome first = experiment("r");
        assertThat(first.code()).as(first.err()).isZero();
        List<String> series = Files.readAllLines(folder.resolve("r/series.csv"));
        Files.delete(folder.resolve("go"));
        Files.delete(folder.resolve("starts"));
        kill("r");
        assertThat(Files.readAllLines(folder.resolve("r/series.csv"))).isEqualTo(series);
        Files.writeString(folder.resolve("go"), "");

        Outcome compared = experiment("r");

        assertThat(compared.code()).as(compared.err()).isZero();
        assertThat(json(compared).path("continued").asInt()).isEqualTo(2);
        assertThat(json(compared).path("identical").asBoolean(false)).isTrue();
        assertThat(files("r")).doesNotContain(JOURNAL);
    }
}
