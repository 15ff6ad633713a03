// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.HashSet;
import java.util.Set;

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
}
