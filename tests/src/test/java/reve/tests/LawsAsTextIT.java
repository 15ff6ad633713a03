// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Set;
import java.util.stream.Stream;

import javax.imageio.ImageIO;

/** Follows docs/laws-as-text.md, block by block, in a folder outside the checkout. */
@Tag("slow")
class LawsAsTextIT {
    private final Path folder;
    private final Shell shell;
    private final Document page;

    LawsAsTextIT(@TempDir Path folder) throws IOException {
        this.folder = folder;
        shell = new Shell(folder);
        page = Document.read(Project.ROOT.resolve("docs/laws-as-text.md"));
    }

    private void write(String text) throws IOException {
        Files.writeString(folder.resolve("wind.law"), text);
    }

    private String run(String title, Server server) throws Exception {
        return shell.run(
                page.titled(title)
                        .text()
                        .replace(" control ", " control --port " + server.port() + " "));
    }

    @Test
    void aWindIsWrittenReplacedMistakenAndRemoved() throws Exception {
        String wind = page.titled("wind.law").text();
        try (Server server = shell.serve(page.titled("serve.sh").text())) {
            write(wind);
            assertThat(run("load.sh", server)).startsWith("load-law: frame ");
            assertThat(run("stronger.sh", server)).startsWith("load-law: frame ");
            write(wind.replace("c (w - velocity)", "c w - velocity"));
            assertThatThrownBy(() -> run("load.sh", server))
                    .hasMessageContaining(page.titled("mistake").text().strip());
            assertThat(run("unload.sh", server)).startsWith("unload-law: frame ");
        }
    }

    @Test
    void aTextIsCheckedAndWrittenAsCpp() throws Exception {
        write(page.titled("wind.law").text());
        shell.run(page.titled("to-cpp.sh").text());
        assertThat(folder.resolve("wind.cpp"))
                .content()
                .contains("force[i] += Real(c) * (w - velocity[i]);")
                .endsWith("VESPER_LAW_LIBRARY(\"wind\", Wind)\n");
        String file = folder.resolve("wind.law").toString();
        Reve.Outcome right = Reve.runAsProcess("law", "check", file);
        assertThat(right.code()).as(right.err()).isZero();
        write("law wind\n  each body:\n    force += velocty\n");
        Reve.Outcome wrong = Reve.runAsProcess("law", "check", file);
        assertThat(wrong.code()).isEqualTo(1);
        assertThat(wrong.err()).contains("wind.law:3:14: nothing here is called 'velocty'");
        assertThat(Reve.run("help", "law").out()).contains("check", "plot", "to-cpp");
        assertThat(Reve.run("law").code()).isEqualTo(2);
    }

    @Test
    void theForceOfALawIsPlotted() throws Exception {
        write(page.titled("lennard_jones.law").text());
        Path picture = folder.resolve("force.png");
        String file = folder.resolve("wind.law").toString();
        Reve.Outcome plot =
                Reve.run("law", "plot", file, "--out", picture.toString(), "--from", "0.9");
        assertThat(plot.code()).as(plot.err()).isZero();
        assertThat(plot.out()).isEqualTo(picture + "\n");
        BufferedImage image = ImageIO.read(picture.toFile());
        assertThat(image.getWidth()).isEqualTo(1600);
        Set<Integer> colours = new HashSet<>();
        for (int x = 0; x < image.getWidth(); x++) {
            for (int y = 0; y < image.getHeight(); y++) {
                colours.add(image.getRGB(x, y));
            }
        }
        assertThat(colours).hasSizeGreaterThan(10); // axes, texts and two lines
        Reve.Outcome json = Reve.run("law", "plot", file, "--out", picture.toString(), "--json");
        JsonNode curve = new JsonMapper().readTree(json.out());
        assertThat(curve.get("picture").asString()).isEqualTo(picture.toString());
        assertThat(curve.get("over").asString()).isEqualTo("distance");
        assertThat(curve.get("points").size()).isEqualTo(201);
        write("law wind\n  each body:\n    force += velocty\n");
        Reve.Outcome wrong = Reve.run("law", "plot", file, "--out", picture.toString());
        assertThat(wrong.code()).isNotZero();
        assertThat(wrong.err()).contains("wind.law:3:14: nothing here is called 'velocty'");
    }

    /** The integrator is of second order, so a quarter of the step drifts much less. */
    @Test
    void theDriftOfTheEnergyIsPlotted() throws Exception {
        String file = Project.ROOT.resolve("laws/hooke_spring/hooke_spring.law").toString();
        Path picture = folder.resolve("drift.png");
        List<String> plot =
                List.of("law", "plot", file, "--over", "time", "--out", picture.toString());
        Reve.Outcome drawn = Reve.run(with(plot, "--seconds", "1"));
        assertThat(drawn.code()).as(drawn.err()).isZero();
        assertThat(drawn.out()).isEqualTo(picture + "\n");
        assertThat(ImageIO.read(picture.toFile()).getWidth()).isEqualTo(1600);
        double coarse = drift(Reve.run(with(plot, "--json", "--dt", "0.02")).out());
        double fine = drift(Reve.run(with(plot, "--json", "--dt", "0.005")).out());
        assertThat(coarse).isBetween(10 * fine, 0.02);
        Reve.Outcome wrong = Reve.run(with(plot, "--to", "3"));
        assertThat(wrong.code()).isEqualTo(2);
        assertThat(wrong.err()).contains("--from and --to do not fit --over time");
        assertThat(Reve.run("law", "plot", file, "--dt", "0.1").err())
                .contains("--seconds and --dt fit --over time only");
    }

    private static String[] with(List<String> command, String... more) {
        return Stream.concat(command.stream(), Stream.of(more)).toArray(String[]::new);
    }

    /** Returns the largest change of the energy, as a fraction of the largest kinetic energy. */
    private static double drift(String run) {
        JsonNode rows = new JsonMapper().readTree(run).get("rows");
        double first =
                rows.get(0).get("kinetic").asDouble() + rows.get(0).get("potential").asDouble();
        double largest = 0;
        double change = 0;
        for (JsonNode row : rows) {
            double kinetic = row.get("kinetic").asDouble();
            largest = Math.max(largest, kinetic);
            change = Math.max(change, Math.abs(kinetic + row.get("potential").asDouble() - first));
        }
        return change / largest;
    }

    @Test
    void aSavedWorldKeepsTheTextOfAShippedLaw(@TempDir Path folder) throws Exception {
        Path world = folder.resolve("fall.yaml");
        Path saved = folder.resolve("saved.yaml");
        Files.writeString(
                world,
                """
                reve: 1
                name: fall
                laws: [gravity_field.law, newton_motion]
                constants: {gravity: [0, -9.81, 0]}
                items:
                  - {name: ball, physical: {shape: sphere, radius: 1}, physics: {mass: 1 kg}}
                """);
        Reve.Outcome run =
                Reve.run("run", world.toString(), "--seconds", "0.1", "--save", saved.toString());
        assertThat(run.code()).as(run.err()).isZero();
        assertThat(Files.readString(saved)).contains("gravity_field.law");
    }

    private static JsonNode report(Server server, String... question) throws Exception {
        List<String> command = new ArrayList<>(List.of("control"));
        command.addAll(List.of(question));
        command.addAll(List.of("--port", server.port()));
        Reve.Outcome outcome = Reve.run(command.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return outcome.out().startsWith("{") ? new JsonMapper().readTree(outcome.out()) : null;
    }

    /** Returns the line of a ledger, by the name of a law or {@code total}. */
    private static JsonNode line(JsonNode lines, String name) {
        for (JsonNode line : lines) {
            for (String key : new String[] {"law", "line", "name"}) {
                if (line.path(key).asString("").equals(name)) {
                    return line;
                }
            }
        }
        throw new AssertionError("no line " + name + " in " + lines);
    }

    @Test
    void aTextIsTypedIntoACommand() throws Exception {
        try (Server server = shell.serve(page.titled("serve.sh").text())) {
            assertThat(run("typed.sh", server)).startsWith("load-law: frame ");
            JsonNode loaded = report(server, "laws").get("loaded");
            assertThat(loaded.findValuesAsString("library")).contains("calm");
            List<String> contents = loaded.findValuesAsString("sha256");
            String right = page.titled("typed.sh").text();
            String wrong = right.replace("kg/s", "kg");
            assertThat(wrong).isNotEqualTo(right);
            assertThatThrownBy(
                            () ->
                                    shell.run(
                                            wrong.replace(
                                                    " control ",
                                                    " control --port " + server.port() + " ")))
                    .hasMessageContaining("law-refused")
                    .hasMessageContaining(":2:23: ")
                    .hasMessageContaining("but 'force' is N (a force)");
            assertThat(report(server, "laws").get("loaded").findValuesAsString("sha256"))
                    .isEqualTo(contents);
        }
    }

    private static double angularMomentum(JsonNode line) {
        return line.get("angularMomentum").get(1).doubleValue();
    }

    @Test
    void theWhirlOfTheSandboxIsLoadedByTheCommandsOfItsReadme() throws Exception {
        List<String> commands =
                Files.readAllLines(Project.WORLDS.resolve("sandbox/README.md")).stream()
                        .filter(line -> line.startsWith("    ./reve "))
                        .map(
                                line ->
                                        line.strip()
                                                .replaceAll(
                                                        "(\\./|)(reve|worlds)(?=[ /])",
                                                        "\"\\$REVE\"/$2"))
                        .toList();
        assertThat(commands).hasSize(3);
        try (Server server = shell.serve(commands.get(0).replace(" --port 7777", ""))) {
            String port = " control --port " + server.port() + " ";
            report(server, "ledger", "open=true");
            assertThat(shell.run(commands.get(1).replace(" control ", port)))
                    .startsWith("load-law: frame ");
            report(server, "pause");
            report(server, "step", "frames=30");
            JsonNode whirl = line(report(server, "ledger").get("lines"), "whirl");
            for (int i = 0; i < 300 && angularMomentum(whirl) <= 1; i++) { // the steps take a while
                whirl = line(report(server, "ledger").get("lines"), "whirl");
            }
            assertThat(angularMomentum(whirl))
                    .as("the air turns around the y axis")
                    .isGreaterThan(1);
            for (JsonNode momentum : whirl.get("momentum")) {
                assertThat(momentum.doubleValue())
                        .as("the grid is symmetric")
                        .isCloseTo(0, within(1e-9));
            }
            report(server, "run");
            assertThat(shell.run(commands.get(2).replace(" control ", port)))
                    .startsWith("unload-law: frame ");
            assertThat(report(server, "laws").get("loaded").findValuesAsString("library"))
                    .containsExactly("hooke_spring", "newton_motion");
        }
    }

    private static final String WELL =
            """
            law well "Attracts all balls to one place."
              parameter k = 3 N/m
              each body:
                energy = 1/2 k |position - (1, 3, 0) m|^2
            """;

    /** Writes the sandbox with undamped springs, an integrator of second order and more laws. */
    private Path sandbox(String laws) throws IOException {
        String text = Files.readString(Project.WORLDS.resolve("sandbox/world.yaml"));
        String changed =
                text.replace("laws: [hooke_spring, newton_motion]", laws)
                        .replace("dampingConstant: 0.5 N*s/m", "dampingConstant: 0 N*s/m");
        assertThat(changed).doesNotContain("newton_motion", "0.5 N*s/m").contains(laws);
        return Files.writeString(folder.resolve("sandbox.yaml"), changed);
    }

    /**
     * The kinetic energy and the potential energies of the springs and of the text have a constant
     * sum. The drift of the integrator is at most 1e-4 of the energy that the balls have at first.
     */
    @Test
    void theLedgerKeepsTheEnergyOfAText() throws Exception {
        Path world =
                sandbox(
                        "laws:\n  - hooke_spring\n  - velocity_verlet\n  - text: |\n"
                                + WELL.indent(6).stripTrailing());
        Reve.Outcome run =
                Reve.run("run", world.toString(), "--seconds", "3", "--ledger", "--json");
        assertThat(run.code()).as(run.err()).isZero();
        JsonNode ledger = new JsonMapper().readTree(run.out()).get("ledger");
        // 27 balls in a grid of 1.5 m, whose middle is 1 m from the middle of the well.
        double first = 0.5 * 3 * (3 * 9 * 2 * 1.5 * 1.5 + 27);
        JsonNode well = line(ledger, "well").get("potentialEnergy");
        assertThat(well.get("initial").doubleValue()).isCloseTo(first, within(1e-9));
        double kinetic = line(ledger, "total").get("energy").doubleValue();
        double potential = 0;
        for (String law : new String[] {"well", "hooke_spring"}) {
            JsonNode energy = line(ledger, law).get("potentialEnergy");
            potential += energy.get("present").doubleValue() - energy.get("initial").doubleValue();
        }
        assertThat(kinetic).as("the balls move").isGreaterThan(0.1 * first);
        assertThat(kinetic + potential).isCloseTo(0, within(1e-4 * first));
    }

    @Test
    void aRunningWorldShowsTheLedgerOfALoadedText() throws Exception {
        Path world = sandbox("laws: [hooke_spring, velocity_verlet]");
        write(WELL);
        try (Server server =
                Server.start(folder, "serve", world.toString(), "--port", "0", "--json")) {
            report(server, "load-law", "file=" + folder.resolve("wind.law"));
            report(server, "pause");
            assertThat(report(server, "ledger").get("lines")).isEmpty();
            report(server, "ledger", "open=true");
            report(server, "step", "frames=60");
            JsonNode lines = report(server, "ledger").get("lines");
            JsonNode well = line(lines, "well");
            double change = well.get("potentialChange").doubleValue();
            assertThat(change).isNotZero();
            assertThat(well.get("energy").doubleValue())
                    .as("work against the change of the potential energy")
                    .isCloseTo(-change, within(1e-3 * well.get("potentialEnergy").doubleValue()));
            double springs = line(lines, "hooke_spring").get("potentialChange").doubleValue();
            assertThat(line(lines, "total").get("energy").doubleValue() + change + springs)
                    .isCloseTo(0, within(1e-4 * 202.5));
        }
    }
}
