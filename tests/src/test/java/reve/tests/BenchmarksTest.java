// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Locale;
import java.util.stream.Stream;

/**
 * The programs in {@code bench/} print their usage and what they lack. The test runs no benchmark.
 */
class BenchmarksTest {
    private static final Path BENCH = Project.ROOT.resolve("bench");

    @TempDir private Path folder;

    @Test
    void everyProgramHasHelpAndAShortForm() throws Exception {
        for (Path program : programs()) {
            Outcome help = Reve.run(List.of(program.toString(), "--help"));
            assertThat(help.code()).as(program + help.err()).isZero();
            assertThat(help.out())
                    .startsWith("usage: " + Project.ROOT.relativize(program))
                    .contains("--quick");
        }
    }

    @Test
    void aFolderThatIsNoJdkIsNamed() throws Exception {
        for (String program : List.of("rules/run", "store/run")) {
            Outcome outcome = run(List.of("REVE_JAVA_HOME=" + folder), program);
            assertThat(outcome.code()).isEqualTo(1);
            assertThat(outcome.err())
                    .isEqualTo(
                            "reve: REVE_JAVA_HOME="
                                    + folder
                                    + " is not a JDK of version 25 or newer; set it to one, or"
                                    + " unset it.\n");
        }
    }

    @Test
    void aMissingProgramIsNamedWithItsPackage() throws Exception {
        Outcome python = Reve.run(List.of("python3", "-c", "import sys; print(sys.executable)"));
        Files.createSymbolicLink(folder.resolve("python3"), Path.of(python.out().strip()));
        for (String program : List.of("spheres/run", "icosahedra/run", "agents/run")) {
            Outcome outcome = run(List.of("PATH=" + folder), program);
            assertThat(outcome.code()).isEqualTo(1);
            assertThat(outcome.err())
                    .isEqualTo(
                            "bench: mvn is missing; install it with: sudo apt-get install maven\n");
        }
    }

    /** Returns a number of the page about laws in Python: the column of the row with this name. */
    private static double inPython(String page, String name, int column) {
        String row =
                page.lines()
                        .filter(line -> line.startsWith("| " + name + " |"))
                        .findFirst()
                        .orElseThrow();
        return Double.parseDouble(row.split("\\|")[column].strip().replace(",", ""));
    }

    @Test
    void thePageOfLawsInPythonSaysTheMeasuredRatios() throws Exception {
        String page = Files.readString(BENCH.resolve("results/laws_in_python.md"));
        double text =
                inPython(page, "Coriolis force in Python", 2)
                        / inPython(page, "Coriolis force as text", 2);
        double numpy = inPython(page, "drag in Python", 3);
        double numba = inPython(page, "drag in Python, compiled by Numba", 3);
        String said =
                Files.readString(Project.ROOT.resolve("docs/laws-in-python.md"))
                        .replaceAll("\\s+", " ");
        assertThat(said)
                .contains(
                        String.format(Locale.ROOT, "takes %.0f times as long as the same", text),
                        String.format(Locale.ROOT, "in NumPy takes %.1f times as long", numpy),
                        String.format(Locale.ROOT, "takes %.1f times as long as the comp", numba));
    }

    private static Outcome run(List<String> environment, String program)
            throws IOException, InterruptedException {
        List<String> command = new ArrayList<>(List.of("/usr/bin/env"));
        command.addAll(environment);
        command.addAll(List.of(BENCH.resolve(program).toString(), "--quick"));
        return Reve.run(command);
    }

    private static List<Path> programs() throws IOException {
        try (Stream<Path> files = Files.walk(BENCH)) {
            List<Path> programs =
                    files.filter(Files::isRegularFile)
                            .filter(Files::isExecutable)
                            .sorted()
                            .toList();
            assertThat(programs).hasSizeGreaterThan(9).contains(BENCH.resolve("agents/run"));
            return programs;
        }
    }
}
