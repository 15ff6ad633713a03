// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.MatchResult;
import java.util.regex.Pattern;

/** Follows docs/tutorial.md, block by block, in a folder outside the checkout. */
@Tag("slow")
class TutorialIT {
    private static final Pattern THERE_AND_BACK = Pattern.compile("there and back: ([\\d.]+) s");
    private static final double PENDULUM_SECONDS = 2 * Math.PI * Math.sqrt(1.4 / 9.81);
    private static final double ERROR = 0.02 * PENDULUM_SECONDS;

    /**
     * Number of measurements of which one must be right. A program that a busy machine delays skips
     * frames, and interpolates over them. A wrong period is wrong every time.
     */
    private static final int MEASUREMENTS = 3;

    private final Path folder;
    private final Shell shell;
    private final Document page;

    TutorialIT(@TempDir Path folder) throws IOException {
        this.folder = folder;
        shell = new Shell(folder);
        page = Document.read(Project.ROOT.resolve("docs/tutorial.md"));
    }

    @Test
    void theSwingIsBuiltPaintedSetInMotionAndMeasured() throws Exception {
        Files.writeString(world(), page.titled("swing.yaml").text());
        shell.run(page.titled("look.sh").text());
        assertThat(folder.resolve("swing.png")).isNotEmptyFile();

        add("semantic.diff");
        add("access.diff");
        String painted = agent("painter.py", "paint.sh");
        assertThat(painted).containsPattern("seat .*'low': True").contains("painted\nrefused: ");

        add("physics.diff");
        assertThat(shell.run(page.titled("run.sh").text()))
                .contains("2 are bodies with physics", "600 frames");

        add("push.diff");
        double seconds = thereAndBack();
        for (int i = 1; i < MEASUREMENTS && Math.abs(seconds - PENDULUM_SECONDS) > ERROR; i++) {
            seconds = thereAndBack();
        }
        assertThat(seconds).isCloseTo(PENDULUM_SECONDS, within(ERROR));
    }

    /** Measures the swing by the program of the page. */
    private double thereAndBack() throws Exception {
        return THERE_AND_BACK
                .matcher(agent("swinger.py", "swing.sh"))
                .results()
                .map(MatchResult::group)
                .map(line -> line.replaceAll("[^\\d.]", ""))
                .mapToDouble(Double::parseDouble)
                .findFirst()
                .orElseThrow();
    }

    @Test
    void physicsIsAddedByPhysicsAspectsLawsAndConstantsAlone() {
        List<String> added =
                page.titled("physics.diff")
                        .text()
                        .lines()
                        .filter(line -> line.startsWith("+"))
                        .map(line -> line.substring(1))
                        .filter(line -> !line.isBlank())
                        .toList();

        assertThat(added)
                .allMatch(
                        line ->
                                line.matches(
                                        "(laws|constants|frame): .*|    physics: .*|  - name: rope|"
                                                + "    kind: spring"));
        assertThat(page.titled("physics.diff").text().lines())
                .noneMatch(line -> line.startsWith("-"));
    }

    /** Serves the present world while an agent works. Returns the agent's output. */
    private String agent(String program, String script) throws Exception {
        try (Server server = shell.serve(page.titled("serve.sh").text())) {
            Files.writeString(
                    folder.resolve(program),
                    page.titled(program).text().replace("7777", server.port()));
            return shell.run(page.titled(script).text());
        }
    }

    /** Adds the lines marked with {@code +} after their context, and checks the file. */
    private void add(String diff) throws Exception {
        List<String> lines = new ArrayList<>(Files.readAllLines(world()));
        int at = 0;
        for (String change : page.titled(diff).text().lines().toList()) {
            if (change.startsWith("+")) {
                lines.add(at++, change.substring(1));
            } else if (!change.equals("@@")) {
                int found = lines.subList(at, lines.size()).indexOf(change.substring(1));
                assertThat(found).as("%s: the file has the line %s", diff, change).isNotNegative();
                at += found + 1;
            }
        }
        Files.write(world(), lines);
        shell.run("\"$REVE/reve\" check swing.yaml");
    }

    private Path world() {
        return folder.resolve("swing.yaml");
    }
}
