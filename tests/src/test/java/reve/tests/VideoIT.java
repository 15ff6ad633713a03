// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.w3c.dom.NamedNodeMap;

import reve.tests.Reve.Outcome;

import java.awt.Graphics2D;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.stream.Stream;

import javax.imageio.ImageIO;
import javax.imageio.ImageReader;
import javax.imageio.metadata.IIOMetadataNode;
import javax.imageio.stream.ImageInputStream;

/** Videos show the pictures that {@code picture} takes at the same times. */
@Tag("slow")
class VideoIT {
    private static final String WORLD = Project.WORLDS.resolve("spring-orbit").toString();
    private static final int WIDTH = 240;
    private static final int HEIGHT = 160;

    @TempDir private Path folder;

    private Outcome video(String world, String name, String... options) throws Exception {
        List<String> command = new ArrayList<>(List.of("video", world));
        command.addAll(List.of("--out", folder.resolve(name).toString()));
        command.addAll(List.of("--size", WIDTH + "x" + HEIGHT));
        command.addAll(List.of(options));
        Outcome outcome = Reve.run(command.toArray(String[]::new));
        assertThat(outcome.code()).as(outcome.err()).isZero();
        return outcome;
    }

    private BufferedImage picture(String at) throws Exception {
        Path picture = folder.resolve("snapshot.png");
        String[] command = {
            "picture",
            WORLD,
            "--at",
            at,
            "--out",
            picture.toString(),
            "--size",
            WIDTH + "x" + HEIGHT
        };
        assertThat(Reve.run(command).code()).isZero();
        return ImageIO.read(picture.toFile());
    }

    private List<String> files(String name) throws IOException {
        try (Stream<Path> files = Files.list(folder.resolve(name))) {
            return files.map(file -> file.getFileName().toString()).sorted().toList();
        }
    }

    /** Returns the mean difference of the colours' parts [0 to 255]. */
    private static double difference(BufferedImage one, BufferedImage other) {
        assertThat(one.getWidth()).isEqualTo(other.getWidth());
        assertThat(one.getHeight()).isEqualTo(other.getHeight());
        long sum = 0;
        for (int y = 0; y < one.getHeight(); y++) {
            for (int x = 0; x < one.getWidth(); x++) {
                for (int shift = 0; shift < 24; shift += 8) {
                    sum +=
                            Math.abs(
                                    (one.getRGB(x, y) >> shift & 0xff)
                                            - (other.getRGB(x, y) >> shift & 0xff));
                }
            }
        }
        return (double) sum / (3L * one.getWidth() * one.getHeight());
    }

    /** A signal leaves neither a video nor a part of one. */
    @Test
    void aVideoThatIsInterruptedLeavesNoFile() throws Exception {
        Process process =
                new ProcessBuilder(
                                Reve.command(
                                        "video",
                                        WORLD,
                                        "--seconds",
                                        "600",
                                        "--out",
                                        folder.resolve("orbit.gif").toString()))
                        .redirectErrorStream(true)
                        .redirectOutput(folder.resolve("printed.txt").toFile())
                        .start();
        try {
            Path part = folder.resolve("orbit.gif.part");
            while (!Files.exists(part)) {
                assertThat(process.isAlive())
                        .as(Files.readString(folder.resolve("printed.txt")))
                        .isTrue();
                Thread.sleep(10);
            }
            process.destroy(); // SIGTERM
            assertThat(process.waitFor()).isNotZero();
        } finally {
            process.destroyForcibly().waitFor();
        }
        assertThat(files("")).containsExactly("printed.txt");
    }

    @Test
    void aFolderHoldsThePicturesOfTheTimes() throws Exception {
        video(WORLD, "frames", "--seconds", "1", "--fps", "4", "--speed", "0.5", "--from", "1");
        assertThat(files("frames"))
                .containsExactly(
                        "000000.png",
                        "000001.png",
                        "000002.png",
                        "000003.png",
                        "000004.png",
                        "000005.png",
                        "000006.png",
                        "000007.png");
        for (String[] known : new String[][] {{"0", "1"}, {"2", "1.25"}, {"7", "1.875"}}) {
            BufferedImage frame =
                    ImageIO.read(folder.resolve("frames/00000" + known[0] + ".png").toFile());
            assertThat(difference(frame, picture(known[1]))).as(known[1]).isZero();
        }
        video(WORLD, "frames", "--seconds", "1", "--fps", "2");
        assertThat(files("frames")).containsExactly("000000.png", "000001.png");
    }

    @Test
    void aRecordingShowsThePicturesOfItsWorld() throws Exception {
        Path log = folder.resolve("run.log");
        Outcome run = Reve.run("run", WORLD, "--seconds", "1", "--record", log.toString());
        assertThat(run.code()).isZero();
        video(log.toString(), "past", "--fps", "5", "--world", WORLD);
        video(WORLD, "live", "--fps", "5", "--seconds", "1.2");
        assertThat(files("past")).hasSize(6).isEqualTo(files("live"));
        for (String name : files("past")) {
            assertThat(
                            Files.mismatch(
                                    folder.resolve("past/" + name), folder.resolve("live/" + name)))
                    .as(name)
                    .isEqualTo(-1);
        }
        Outcome refused =
                Reve.run("video", log.toString(), "--out", folder + "/x", "--camera", "side");
        assertThat(refused.err()).contains("name the world file with --world");
    }

    @Test
    void aGifRepeatsThePicturesInTime() throws Exception {
        video(WORLD, "orbit.gif", "--seconds", "1", "--fps", "30");
        ImageReader reader = ImageIO.getImageReadersByFormatName("gif").next();
        try (ImageInputStream in =
                ImageIO.createImageInputStream(folder.resolve("orbit.gif").toFile())) {
            reader.setInput(in);
            assertThat(reader.getNumImages(true)).isEqualTo(30);
            var canvas = new BufferedImage(WIDTH, HEIGHT, BufferedImage.TYPE_INT_RGB);
            Graphics2D graphics = canvas.createGraphics();
            int hundredths = 0;
            for (int i = 0; i < 30; i++) {
                var tree =
                        (IIOMetadataNode)
                                reader.getImageMetadata(i).getAsTree("javax_imageio_gif_image_1.0");
                NamedNodeMap place = attributes(tree, "ImageDescriptor");
                graphics.drawImage(
                        reader.read(i),
                        Integer.parseInt(place.getNamedItem("imageLeftPosition").getNodeValue()),
                        Integer.parseInt(place.getNamedItem("imageTopPosition").getNodeValue()),
                        null);
                hundredths +=
                        Integer.parseInt(
                                attributes(tree, "GraphicControlExtension")
                                        .getNamedItem("delayTime")
                                        .getNodeValue());
                if (i == 0) {
                    var loop =
                            (IIOMetadataNode)
                                    tree.getElementsByTagName("ApplicationExtension").item(0);
                    assertThat((byte[]) loop.getUserObject()).containsExactly(1, 0, 0);
                }
                if (i % 15 == 0) {
                    // 255 colours: a few levels of 256 on average
                    assertThat(difference(canvas, picture(i == 0 ? "0" : "0.5"))).isLessThan(4);
                }
            }
            graphics.dispose();
            assertThat(hundredths).isEqualTo(100);
        } finally {
            reader.dispose();
        }
        byte[] first = Files.readAllBytes(folder.resolve("orbit.gif"));
        video(WORLD, "orbit.gif", "--seconds", "1", "--fps", "30");
        assertThat(Files.readAllBytes(folder.resolve("orbit.gif"))).isEqualTo(first);
    }

    @Test
    void theCommandOfTheReadmeMakesItsAnimation() throws Exception {
        String readme = Files.readString(Project.ROOT.resolve("README.md"));
        String line =
                readme.lines()
                        .filter(each -> each.startsWith("    ./reve video "))
                        .findFirst()
                        .orElseThrow();
        List<String> command = new ArrayList<>(List.of(line.strip().split(" ")));
        command.removeFirst();
        command.set(1, Project.ROOT.resolve(command.get(1)).toString());
        Path made = folder.resolve(command.getLast());
        command.set(command.size() - 1, made.toString());
        assertThat(Reve.run(command.toArray(String[]::new)).code()).isZero();
        Path kept = Project.WORLDS.resolve("spring-orbit/orbit.gif");
        assertThat(readme).contains("](worlds/spring-orbit/orbit.gif)");
        assertThat(Files.size(kept)).isLessThan(2_000_000);
        ImageReader[] readers = new ImageReader[2];
        for (int i = 0; i < 2; i++) {
            readers[i] = ImageIO.getImageReadersByFormatName("gif").next();
            readers[i].setInput(ImageIO.createImageInputStream((i == 0 ? made : kept).toFile()));
        }
        assertThat(readers[0].getNumImages(true)).isEqualTo(readers[1].getNumImages(true));
        // pictures differ a little between processors, which the renderer's library causes
        assertThat(difference(readers[0].read(0), readers[1].read(0))).isLessThan(2);
        for (ImageReader reader : readers) {
            ((ImageInputStream) reader.getInput()).close();
            reader.dispose();
        }
    }

    private static NamedNodeMap attributes(IIOMetadataNode tree, String name) {
        return tree.getElementsByTagName(name).item(0).getAttributes();
    }

    @Test
    void ffmpegEncodesThePicturesThatItDecodesAgain() throws Exception {
        for (String name : List.of("orbit.mp4", "orbit.webm")) {
            video(WORLD, name, "--seconds", "1", "--fps", "10");
            Path decoded = Files.createDirectory(folder.resolve("of-" + name));
            Outcome ffmpeg =
                    Reve.run(
                            List.of(
                                    "ffmpeg",
                                    "-v",
                                    "error",
                                    "-i",
                                    folder.resolve(name).toString(),
                                    decoded.resolve("%02d.png").toString()));
            assertThat(ffmpeg.code()).as(ffmpeg.err()).isZero();
            assertThat(files("of-" + name)).hasSize(10);
            BufferedImage sixth = ImageIO.read(decoded.resolve("06.png").toFile());
            assertThat(difference(sixth, picture("0.5"))).as(name).isLessThan(4);
        }
        video(WORLD, "orbit.webp", "--seconds", "0.4", "--fps", "10");
        byte[] webp = Files.readAllBytes(folder.resolve("orbit.webp"));
        assertThat(new String(webp, 0, 12, java.nio.charset.StandardCharsets.ISO_8859_1))
                .startsWith("RIFF")
                .endsWith("WEBP");
    }

    @Test
    void withoutFfmpegTheMessageSaysHowToGetItAndWhatNeedsNone() throws Exception {
        List<String> command = new ArrayList<>(List.of("env", "PATH=" + folder));
        command.addAll(
                Reve.commandIn(
                        Project.ROOT.resolve("build/native"),
                        "video",
                        WORLD,
                        "--out",
                        folder.resolve("x.mp4").toString()));
        Outcome refused = Reve.run(command);
        assertThat(refused.code()).isEqualTo(2);
        assertThat(refused.err())
                .contains("needs the program ffmpeg", "apt-get install ffmpeg", ".gif");
        assertThat(folder.resolve("x.mp4")).doesNotExist();
    }

    @Test
    void theReasonOfAFailingFfmpegIsTold() throws Exception {
        Path fake = Files.createDirectory(folder.resolve("bin")).resolve("ffmpeg");
        Files.writeString(fake, "#!/bin/sh\necho no encoder libx264 >&2\nexit 3\n");
        assertThat(fake.toFile().setExecutable(true)).isTrue();
        List<String> command = new ArrayList<>(List.of("env", "PATH=" + fake.getParent()));
        command.addAll(
                Reve.commandIn(
                        Project.ROOT.resolve("build/native"),
                        "video",
                        WORLD,
                        "--seconds",
                        "1",
                        "--out",
                        folder.resolve("x.mp4").toString()));
        Outcome failed = Reve.run(command);
        assertThat(failed.code()).isEqualTo(1);
        assertThat(failed.err()).contains("x.mp4: ffmpeg failed: no encoder libx264");
        assertThat(folder.resolve("x.mp4")).doesNotExist();
        assertThat(folder.resolve("x.mp4.part")).doesNotExist();
    }

    @Test
    void aFailedVideoLeavesNoFileAndAForeignFileStays() throws Exception {
        Path letter = Files.writeString(folder.resolve("letter.gif"), "to a friend");
        Outcome refused = Reve.run("video", WORLD, "--out", letter.toString());
        assertThat(refused.err()).contains("exists and is not a GIF");
        assertThat(Files.readString(letter)).isEqualTo("to a friend");
        Outcome ending = Reve.run("video", WORLD, "--out", folder.resolve("x.avi").toString());
        assertThat(ending.err()).contains("expected a name that ends in .mp4");
        Outcome fast =
                Reve.run(
                        "video", WORLD, "--out", folder.resolve("x.gif").toString(), "--fps", "60");
        assertThat(fast.err()).contains("--fps is 60, expected 1 to 50");
        Path log = folder.resolve("run.log");
        Reve.run("run", WORLD, "--seconds", "0.2", "--record", log.toString());
        Outcome early =
                Reve.run(
                        "video",
                        log.toString(),
                        "--out",
                        folder.resolve("x.gif").toString(),
                        "--from",
                        "5");
        assertThat(early.code()).isEqualTo(1);
        assertThat(early.err()).contains("ends before --from 5 s");
        try (Stream<Path> left = Files.list(folder)) {
            assertThat(left).noneMatch(file -> file.toString().contains("x.gif"));
        }
    }
}
