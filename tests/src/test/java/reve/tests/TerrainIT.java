// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.tests.Reve.Outcome;
import reve.worlds.server.Simulation;

import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;

import javax.imageio.ImageIO;

/** Terrains whose heights are in a file: bodies touch them, packs take them, pictures show them. */
class TerrainIT {
    private static final int COLUMNS = 81;
    private static final int ROWS = 21;
    private static final double G = 9.81;
    private static final double SLOPE = Math.atan2(3, 16);

    @TempDir private Path folder;

    /** Writes a slope that falls by 3 m along 16 m, once as an image and once as a text. */
    private void writeSlope() throws IOException {
        var image = new BufferedImage(COLUMNS, ROWS, BufferedImage.TYPE_USHORT_GRAY);
        var text = new StringBuilder("# a slope\n");
        for (int row = 0; row < ROWS; row++) {
            for (int column = 0; column < COLUMNS; column++) {
                int sample = (COLUMNS - 1 - column) * 819;
                image.getRaster().setSample(column, row, 0, sample);
                text.append(3.0 * sample / 65_520).append(' ');
            }
            text.append('\n');
        }
        ImageIO.write(image, "png", folder.resolve("slope.png").toFile());
        Files.writeString(folder.resolve("slope.txt"), text);
    }

    private Path world(String heights) throws IOException {
        return Files.writeString(
                folder.resolve("world.yaml"),
                """
                reve: 1
                name: slope
                frame: {rate: 60, steps: 4}
                laws: [gravity_field, {name: rigid_contact, parameters: {friction: 0.6}}]
                constants: {gravity: [0, -9.81, 0]}
                camera: {eye: [0, 30, 0.1], target: [0, 0, 0], fov: 40 deg}
                items:
                  - {name: slope, physical: {shape: terrain, size: [16, 4], colour: "#c03020", %s}}
                  - {name: ball, physical: {shape: sphere, radius: 0.2, location: [-6, %s, 0.13]},
                     physics: {density: 1000}}
                """
                        .formatted(heights, 2.625 + 0.2 / Math.cos(SLOPE)));
    }

    /**
     * A ball rolls down a slope with 5/7 g sin α. It begins on the slope: 0.2 / cos α above the
     * height at x = -6, which is 2.625 m.
     */
    @ParameterizedTest
    @ValueSource(strings = {"file: slope.png, heightRange: [0, 3.0006868]", "file: slope.txt"})
    void aBallRollsDownTheSlopeOfTheFileAsTheClosedFormSays(String heights) throws Exception {
        writeSlope();
        try (Simulation simulation = new Simulation(WorldFile.load(world(heights)), Pacing.FAST)) {
            simulation.loop().run(30);
            double before = speed(simulation);
            simulation.loop().run(60);
            double expected = 5.0 / 7 * G * Math.sin(SLOPE);
            assertThat(speed(simulation) - before).isCloseTo(expected, within(0.01 * expected));
            double[] at = simulation.world().find("ball").orElseThrow().physical().location();
            assertThat(at[1] - 1.5 + at[0] * 3 / 16)
                    .as("height above the slope")
                    .isCloseTo(0.2 / Math.cos(SLOPE), within(2e-3));
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    private static double speed(Simulation simulation) {
        double[] v = simulation.world().find("ball").orElseThrow().physics().vector("velocity");
        return Math.hypot(v[0], Math.hypot(v[1], v[2]));
    }

    @Test
    void aPackTakesTheFileOfATerrain() throws Exception {
        writeSlope();
        Path world = world("file: slope.png, heightRange: 0 3 m");
        Path pack = folder.resolve("a.reve");
        Outcome packed = Reve.run("pack", world.toString(), "--out", pack.toString());
        assertThat(packed.code()).as(packed.err()).isZero();
        assertThat(packed.out()).contains("slope, 2 files");
        Path elsewhere = Files.createDirectory(folder.resolve("elsewhere")).resolve("a.reve");
        Files.move(pack, elsewhere);
        Files.delete(folder.resolve("slope.png"));
        Outcome check = Reve.run("check", elsewhere.toString());
        assertThat(check.code()).as(check.err()).isZero();
        Outcome missing = Reve.run("check", world.toString());
        assertThat(missing.code()).isEqualTo(3);
        assertThat(missing.err())
                .contains("slope.png: there is no such file in the world's folder");
    }

    /** Seen from above, the terrain fills the middle of the picture with its colour. */
    @Test
    void aPictureShowsTheTerrain() throws Exception {
        writeSlope();
        Path world = world("file: slope.png, heightRange: 0 3 m");
        Path picture = folder.resolve("picture.png");
        Outcome outcome =
                Reve.run(
                        "picture",
                        world.toString(),
                        "--size",
                        "320x240",
                        "--out",
                        picture.toString());
        assertThat(outcome.code()).as(outcome.err()).isZero();
        BufferedImage image = ImageIO.read(picture.toFile());
        int red = 0;
        for (int x = 120; x < 200; x++) {
            int rgb = image.getRGB(x, 120);
            red += (rgb >> 16 & 255) > 2 * (rgb >> 8 & 255) ? 1 : 0;
        }
        assertThat(red).as("red points in the middle row").isGreaterThan(60);
    }
}
