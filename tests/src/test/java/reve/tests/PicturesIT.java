// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.tests.Reve.Outcome;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.awt.image.BufferedImage;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;

import javax.imageio.ImageIO;

/** The cameras and layers of {@code picture}, compared with the geometry of their scene. */
@Tag("slow")
class PicturesIT {
    private static final int WIDTH = 301;
    private static final int HEIGHT = 201;

    @TempDir private Path folder;
    private Path world;

    @BeforeEach
    void writeWorld() throws Exception {
        world =
                Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: studio
                        laws: [gravity_field, newton_motion, angular_motion]
                        constants: {gravity: [0, -10, 0]}
                        camera: {eye: [0, 3, 14], target: [0, 2, 0]}
                        cameras:
                          same: {eye: [0, 3, 14], target: [0, 2, 0]}
                          chase: {follow: ball, eye: [0, 0, 4]}
                          rider: {follow: drum, turning: true, eye: [0, 0, 6]}
                          watch: {eye: [5, 1, 9], lookAt: ball}
                          path:
                            target: [20, 2, 0]
                            keyframes: [{time: 0, eye: [20, 2, 9]}, {time: 1, eye: [20, 2, 5]}]
                        items:
                          - {name: ball, physical: {shape: sphere, radius: 0.5, location: [-3, 5, 0], colour: "#e67e22"}, physics: {mass: 1 kg, velocity: [2, 3, 0]}}
                          - {name: crate, physical: {shape: box, size: [1, 2, 1], location: [2, 1, 0], colour: "#2980b9"}}
                          - name: drum
                            physical: {shape: box, size: [2, 2, 2], location: [0, 50, 0]}
                            physics: {mass: 1, inertia: [1, 1, 1], angularVelocity: [0, 1.5, 0], velocity: [0, 5, 0]}
                          - {name: post, physical: {shape: box, size: [1, 1, 2], location: [20, 2, 0]}}
                        """);
    }

    private JsonNode picture(String... options) throws Exception {
        List<String> command = new ArrayList<>(List.of("picture", world.toString(), "--json"));
        command.addAll(List.of("--out", folder.resolve("picture.png").toString()));
        command.addAll(List.of("--size", WIDTH + "x" + HEIGHT));
        command.addAll(List.of(options));
        Outcome outcome = Reve.run(command.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return new JsonMapper().readTree(outcome.out());
    }

    private BufferedImage picture() throws Exception {
        return ImageIO.read(folder.resolve("picture.png").toFile());
    }

    /** Reads a file in NumPy's format and checks its header. */
    private ByteBuffer numpy(String name, String type) throws Exception {
        ByteBuffer file =
                ByteBuffer.wrap(Files.readAllBytes(folder.resolve(name)))
                        .order(ByteOrder.LITTLE_ENDIAN);
        byte[] head = new byte[file.getShort(8)];
        file.get(10, head);
        assertThat((10 + head.length) % 64).isZero();
        assertThat(new String(head, StandardCharsets.US_ASCII).strip())
                .isEqualTo(
                        "{'descr': '"
                                + type
                                + "', 'fortran_order': False, 'shape': ("
                                + HEIGHT
                                + ", "
                                + WIDTH
                                + "), }");
        ByteBuffer content =
                file.slice(10 + head.length, file.limit() - 10 - head.length)
                        .order(ByteOrder.LITTLE_ENDIAN);
        assertThat(content.remaining()).isEqualTo(4 * WIDTH * HEIGHT);
        return content;
    }

    /** Returns the mean place of the pixels of an item, and their number. */
    private static double[] centre(ByteBuffer items, long id) {
        double x = 0;
        double y = 0;
        int count = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            if (items.getInt(4 * i) == id) {
                x += i % WIDTH;
                y += i / WIDTH;
                count++;
            }
        }
        return new double[] {x / count, y / count, count};
    }

    private static long id(JsonNode told, String name) {
        for (JsonNode item : told.path("items")) {
            if (item.path("name").asString().equals(name)) {
                return item.path("id").asLong();
            }
        }
        throw new AssertionError(told + " has no item " + name);
    }

    @Test
    void aNamedCameraTakesThePictureOfTheWorldsCameraAtTheSamePlace() throws Exception {
        picture("--at", "0.5");
        byte[] usual = Files.readAllBytes(folder.resolve("picture.png"));
        picture("--at", "0.5", "--camera", "same");
        assertThat(Files.readAllBytes(folder.resolve("picture.png"))).isEqualTo(usual);
        picture("--at", "0.5", "--camera", "watch");
        assertThat(Files.readAllBytes(folder.resolve("picture.png"))).isNotEqualTo(usual);
    }

    @Test
    void aCameraFollowsItsItemAndMeasuresItsDistance() throws Exception {
        for (String time : List.of("0", "0.4", "1")) {
            for (String camera : List.of("chase", "watch")) {
                String[] options = {
                    "--at",
                    time,
                    "--camera",
                    camera,
                    "--segmentation",
                    folder.resolve("items.npy").toString(),
                    "--depth",
                    folder.resolve("depth.npy").toString()
                };
                JsonNode told = picture(options);
                double[] centre = centre(numpy("items.npy", "<u4"), id(told, "ball"));
                assertThat(centre[0]).as("%s at %s s", camera, time).isCloseTo(150, within(1.0));
                assertThat(centre[1]).as("%s at %s s", camera, time).isCloseTo(100, within(1.0));
                float depth = numpy("depth.npy", "<f4").getFloat(4 * (100 * WIDTH + 150));
                if (camera.equals("chase")) {
                    assertThat(depth).isCloseTo(3.5f, within(2e-3f));
                }
            }
        }
    }

    @Test
    void aTurningCameraSeesItsTurningItemAtRest() throws Exception {
        double[] sizes = new double[2];
        for (int i = 0; i < 2; i++) {
            JsonNode told =
                    picture(
                            "--at",
                            i == 0 ? "0" : "0.7",
                            "--camera",
                            "rider",
                            "--segmentation",
                            folder.resolve("items.npy").toString());
            sizes[i] = centre(numpy("items.npy", "<u4"), id(told, "drum"))[2];
        }
        // a cube that turned by 60 degrees would show a wider outline
        assertThat(sizes[1]).isCloseTo(sizes[0], within(0.01 * sizes[0]));
    }

    @Test
    void aPathIsAtItsKeysAndTheDepthPngHasTheDistance() throws Exception {
        for (String[] known : new String[][] {{"0", "8"}, {"0.5", "6"}, {"1", "4"}, {"2", "4"}}) {
            JsonNode told =
                    picture(
                            "--at",
                            known[0],
                            "--camera",
                            "path",
                            "--depth",
                            folder.resolve("depth.png").toString());
            double step = told.path("depthStep").asDouble();
            var grey = ImageIO.read(folder.resolve("depth.png").toFile()).getRaster();
            assertThat(grey.getSample(150, 100, 0) * step)
                    .as("at %s s", known[0])
                    .isCloseTo(Double.parseDouble(known[1]), within(2 * step));
            assertThat(grey.getSampleModel().getSampleSize(0)).isEqualTo(16);
        }
    }

    @Test
    void theColoursOfASegmentationAreThoseOfTheItemsThatItNames() throws Exception {
        JsonNode told =
                picture(
                        "--segmentation",
                        folder.resolve("items.png").toString(),
                        "--at",
                        "0.2",
                        "--camera",
                        "same");
        var seen = new java.util.TreeSet<String>();
        BufferedImage image = ImageIO.read(folder.resolve("items.png").toFile());
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            seen.add("#%06x".formatted(image.getRGB(i % WIDTH, i / WIDTH) & 0xffffff));
        }
        var named = new java.util.TreeSet<>(List.of("#000000"));
        told.path("items").forEach(item -> named.add(item.path("colour").asString()));
        assertThat(seen).isEqualTo(named).hasSizeGreaterThan(2);
    }

    @Test
    void labelsStandAboveTheItems() throws Exception {
        picture("--at", "0");
        BufferedImage bare = picture();
        JsonNode told =
                picture(
                        "--at",
                        "0",
                        "--labels",
                        "--segmentation",
                        folder.resolve("items.npy").toString());
        BufferedImage labelled = picture();
        ByteBuffer items = numpy("items.npy", "<u4");
        long ball = id(told, "ball");
        double[] centre = centre(items, ball);
        int top = 0;
        while (items.getInt(4 * (top * WIDTH + (int) centre[0])) != ball) {
            top++;
        }
        int dark = 0;
        for (int y = Math.max(0, top - 12); y < top; y++) {
            for (int x = (int) centre[0] - 15; x < centre[0] + 15; x++) {
                dark += (labelled.getRGB(x, y) & 0xff) < 110 ? 1 : 0;
                assertThat(bare.getRGB(x, y) & 0xff).isGreaterThan(110);
            }
        }
        assertThat(dark).as("ink above the ball").isGreaterThan(10);
    }

    /** The two small boxes are 2 m apart and both at the distance of the camera's target. */
    @Test
    void theScaleBarIsAsLongAsTheDistanceOfTwoPointsAtTheTarget() throws Exception {
        Files.writeString(
                world,
                """
                reve: 1
                name: rule
                camera: {eye: [6, 5, 4], target: [0, 1, 0], fov: 40 deg}
                items:
                  - {name: left, physical: {shape: box, size: [0.1, 0.1, 0.1], location: [-0.5547, 1, 0.83205]}}
                  - {name: right, physical: {shape: box, size: [0.1, 0.1, 0.1], location: [0.5547, 1, -0.83205]}}
                """);
        JsonNode told =
                picture("--scale-bar", "--segmentation", folder.resolve("items.npy").toString());
        ByteBuffer items = numpy("items.npy", "<u4");
        double[] left = centre(items, id(told, "left"));
        double[] right = centre(items, id(told, "right"));
        assertThat(left[1]).as("a level line").isCloseTo(right[1], within(0.6));
        double pixelsOfTwoMetres = right[0] - left[0];
        assertThat(pixelsOfTwoMetres).isGreaterThan(50);

        BufferedImage picture = picture();
        int longest = 0;
        for (int y = HEIGHT / 2; y < HEIGHT; y++) {
            int length = 0;
            for (int x = WIDTH / 2; x < WIDTH; x++) {
                length = (picture.getRGB(x, y) & 0xffffff) == 0x1e1e1e ? length + 1 : 0;
                longest = Math.max(longest, length);
            }
        }
        double metres = told.get("scaleBar").asDouble();
        assertThat(metres).isEqualTo(2);
        assertThat(longest).isLessThanOrEqualTo(WIDTH / 4);
        assertThat((double) longest).isCloseTo(pixelsOfTwoMetres * metres / 2, within(1.0));
    }

    @Test
    void aContactSheetShowsEqualTimes() throws Exception {
        JsonNode told = picture("--at", "1", "--sheet", "3x2");
        assertThat(told.path("times").toString()).isEqualTo("[0.0,0.2,0.4,0.6,0.8,1.0]");
        BufferedImage all = picture();
        assertThat(all.getWidth()).isEqualTo(3 * WIDTH);
        assertThat(all.getHeight()).isEqualTo(2 * HEIGHT);
        picture("--at", "0.8");
        BufferedImage fifth = picture();
        for (int y = 0; y < HEIGHT / 2; y++) { // the caption is below
            for (int x = 0; x < WIDTH; x++) {
                assertThat(all.getRGB(WIDTH + x, HEIGHT + y)).isEqualTo(fifth.getRGB(x, y));
            }
        }
    }

    @Test
    void wrongOptionsAreExplained() throws Exception {
        String out = folder.resolve("x.png").toString();
        assertThat(Reve.run("picture", world.toString(), "--out", out, "--camera", "chasse").err())
                .contains("no camera `chasse`; did you mean `chase`?; it has same, chase, rider");
        assertThat(Reve.run("picture", world.toString(), "--out", out, "--depth", "d.exr").err())
                .contains("--depth d.exr: expected a name that ends in .png or .npy");
        assertThat(Reve.run("picture", world.toString(), "--out", out, "--sheet", "3").err())
                .contains("'3' is no grid, expected e.g. 3x2");
        assertThat(Reve.run("picture", world.toString(), "--out", out, "--sheet", "3x2").err())
                .contains("expected --at above 0");
    }
}
