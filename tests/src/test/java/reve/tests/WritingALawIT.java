// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * Follows docs/writing-a-law.md, block by block, in a folder outside the checkout. Two things
 * differ: the port, and the reports of the server, which are JSON.
 */
@Tag("slow")
class WritingALawIT {
    private static final Pattern SPEED = Pattern.compile("t = +([\\d.]+) s .* at +(-?[\\d.]+) m/s");

    /** The gain of speed of red per second that the page states, c w / m [m/s²]. */
    private static final double ACCELERATION = 100 * 5 / 1000.0;

    private final Path folder;
    private final Shell shell;
    private final Document page;

    WritingALawIT(@TempDir Path folder) throws IOException {
        this.folder = folder;
        shell = new Shell(folder);
        page = Document.read(Project.ROOT.resolve("docs/writing-a-law.md"));
    }

    @Test
    void aNewLawIsBuiltAndTestedByTheCommandsThatArePrinted() throws Exception {
        String said = shell.run("\"$REVE/build/current/bin/reve\" new law 'soft_wind'");
        List<String> commands =
                said.lines().filter(line -> line.startsWith("  ")).map(String::strip).toList();
        assertThat(commands).hasSize(2);
        for (String command : commands) {
            shell.run(command);
        }
        assertThat(folder.resolve("soft_wind/build/libvesper_law_soft_wind.so")).exists();
    }

    @Test
    void theLawOfThePageIsBuiltDroppedActsAndStops() throws Exception {
        for (String file : List.of("uniform_wind.cpp", "CMakeLists.txt")) {
            Files.writeString(folder.resolve(file), page.titled(file).text());
        }
        shell.run(page.titled("build.sh").text());

        try (Server server = shell.serve(page.titled("serve.sh").text())) {
            Files.writeString(
                    folder.resolve("watch.py"),
                    page.titled("watch.py").text().replace("7777", server.port()));

            BufferedReader watcher = watch().inputReader();
            assertThat(List.of(speed(watcher), speed(watcher), speed(watcher)))
                    .as("nothing moves along z before the drop")
                    .allSatisfy(speed -> assertThat(speed[1]).isZero());

            shell.run(page.titled("drop.sh").text());
            JsonNode loaded = server.events().await("law-loaded", WritingALawIT::isTheWind);
            List<double[]> windy = speedsAfter(loaded, watcher);
            assertThat(gain(windy))
                    .as("m/s per second in the wind")
                    .isBetween(0.9 * ACCELERATION, ACCELERATION);

            shell.run(page.titled("remove.sh").text());
            JsonNode unloaded = server.events().await("law-unloaded", WritingALawIT::isTheWind);
            assertThat(unloaded.get("frame").asLong()).isGreaterThan(loaded.get("frame").asLong());
            List<double[]> calm = speedsAfter(unloaded, watcher);
            assertThat(Math.abs(gain(calm)))
                    .as("m/s per second after the wind")
                    .isLessThan(0.02 * ACCELERATION);
            assertThat(calm.getLast()[1]).as("speed that is kept").isGreaterThan(ACCELERATION);
        }
    }

    private static boolean isTheWind(JsonNode event) {
        return event.get("library").asString().equals("uniform_wind");
    }

    /** (time [s], speed along z [m/s]) of the next line that the watching agent prints. */
    private double[] speed(BufferedReader watcher) throws IOException {
        String line = watcher.readLine();
        assertThat(line).as(shell.messages()).isNotNull();
        Matcher speed = SPEED.matcher(line);
        assertThat(speed.find()).as(line).isTrue();
        return new double[] {
            Double.parseDouble(speed.group(1)), Double.parseDouble(speed.group(2))
        };
    }

    /**
     * The mean speeds that were measured completely in the five seconds of world time after an
     * event. Each of them belongs to the middle of the time between two lines.
     */
    private List<double[]> speedsAfter(JsonNode event, BufferedReader watcher) throws IOException {
        double start = event.get("time").asDouble();
        List<double[]> speeds = new ArrayList<>();
        double before = speed(watcher)[0];
        for (double[] next = speed(watcher); next[0] <= start + 5; next = speed(watcher)) {
            if (before >= start) {
                speeds.add(new double[] {(before + next[0]) / 2, next[1]});
            }
            before = next[0];
        }
        return speeds;
    }

    private static double gain(List<double[]> speeds) {
        double[] first = speeds.getFirst();
        double[] last = speeds.getLast();
        return (last[1] - first[1]) / (last[0] - first[0]);
    }

    /** Starts the watching agent, which ends with the server at the latest. */
    private Process watch() throws IOException {
        return shell.start(page.titled("watch.sh").text().strip() + " 100000\n");
    }
}
