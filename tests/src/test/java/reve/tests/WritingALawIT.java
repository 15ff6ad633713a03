package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.BufferedReader;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

/**
 * Does what docs/writing-a-law.md says, block by block, in a folder outside the checkout. Only the
 * port is another one, and the server reports as JSON.
 */
class WritingALawIT {
    private static final Pattern SPEED = Pattern.compile("t = +([\\d.]+) s .* at +(-?[\\d.]+) m/s");
    /** c w / m: what the page says red gains per second. */
    private static final double ACCELERATION = 100 * 5 / 1000.0;

    @TempDir
    private Path folder;

    private final Document page;

    WritingALawIT() throws IOException {
        page = Document.read(Project.ROOT.resolve("docs/writing-a-law.md"));
    }

    @Test
    void theLawOfThePageIsBuiltDroppedActsAndStops() throws Exception {
        for (String file : List.of("uniform_wind.cpp", "CMakeLists.txt")) {
            Files.writeString(folder.resolve(file), page.titled(file).text());
        }
        finish(shell(page.titled("build.sh").text()));

        Process server = shell(page.titled("serve.sh").text().strip() + " --port 0 --json\n");
        try (BufferedReader events = server.inputReader()) {
            String port = await(events, "ready", "").get("agentPort").asString();
            Files.writeString(folder.resolve("watch.py"), page.titled("watch.py").text().replace("7777", port));

            Process still = watch(3);
            assertThat(speeds(still)).as("nothing moves along z before the drop")
                    .allSatisfy(speed -> assertThat(speed[1]).isZero());

            finish(shell(page.titled("drop.sh").text()));
            JsonNode loaded = await(events, "law-loaded", "uniform_wind");
            List<double[]> windy = speeds(watch(4));
            assertThat(gain(windy)).as("m/s per second in the wind").isBetween(0.9 * ACCELERATION, ACCELERATION);

            finish(shell(page.titled("remove.sh").text()));
            JsonNode unloaded = await(events, "law-unloaded", "uniform_wind");
            assertThat(unloaded.get("frame").asLong()).isGreaterThan(loaded.get("frame").asLong());
            List<double[]> calm = speeds(watch(4));
            assertThat(Math.abs(gain(calm))).as("m/s per second after the wind").isLessThan(0.02 * ACCELERATION);
            assertThat(calm.getLast()[1]).as("speed that is kept").isGreaterThan(ACCELERATION);
        } finally {
            server.descendants().forEach(ProcessHandle::destroy);
            server.destroy();
            server.waitFor();
        }
    }

    /** (time [s], speed along z [m/s]) for each line that the watching agent printed. */
    private static List<double[]> speeds(Process watcher) throws Exception {
        List<double[]> speeds = new ArrayList<>();
        for (String line : finish(watcher).split("\n")) {
            Matcher speed = SPEED.matcher(line);
            assertThat(speed.find()).as(line).isTrue();
            speeds.add(new double[] {Double.parseDouble(speed.group(1)), Double.parseDouble(speed.group(2))});
        }
        return speeds;
    }

    private static double gain(List<double[]> speeds) {
        double[] first = speeds.getFirst();
        double[] last = speeds.getLast();
        return (last[1] - first[1]) / (last[0] - first[0]);
    }

    private Process watch(int lines) throws IOException {
        return shell(page.titled("watch.sh").text().strip() + " " + lines + "\n");
    }

    private Process shell(String script) throws IOException {
        ProcessBuilder builder = new ProcessBuilder("bash", "-euc", script).directory(folder.toFile())
                .redirectError(folder.resolve("errors.txt").toFile());
        builder.environment().put("REVE", Project.ROOT.toString());
        return builder.start();
    }

    private String finishMessage() throws IOException {
        return Files.readString(folder.resolve("errors.txt"));
    }

    private static String finish(Process process) throws Exception {
        String out = new String(process.getInputStream().readAllBytes());
        assertThat(process.waitFor()).as(out).isZero();
        return out;
    }

    private JsonNode await(BufferedReader events, String event, String library) throws IOException {
        for (String line = events.readLine(); line != null; line = events.readLine()) {
            JsonNode node = new JsonMapper().readTree(line);
            if (node.path("event").asString("").equals(event)
                    && (library.isEmpty() || node.path("library").asString("").equals(library))) {
                return node;
            }
        }
        throw new AssertionError("the server ended without '" + event + "': " + finishMessage());
    }
}
