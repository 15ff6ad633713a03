// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.api.io.TempDir;

import reve.core.world.Colour;
import reve.core.world.Mesh;
import reve.core.world.Shape;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.time.Duration;
import java.util.concurrent.CompletableFuture;

@Timeout(120) // a hang is a failure
class RendererIT {

    private static final int RED = Colour.parse("#ff0000").rgba();
    private static final int BLUE = Colour.parse("#0000ff").rgba();
    private static final Environment BLACK =
            new Environment(
                    Colour.parse("#000000"), Colour.parse("#000000"), new Point(0, 1, 0), 0.5, 0.3);

    private final Renderer renderer = renderer(Renderer.DEFAULT_DEADLINE);
    @TempDir private Path folder;

    private static Renderer renderer(Duration deadline) {
        return new Renderer(
                Path.of(System.getProperty("reve.native.path", "build/native")), deadline);
    }

    @AfterEach
    void close() {
        renderer.close();
    }

    /** A scene with 40 pixels per metre on a black background. The camera looks along -z. */
    private static Scene scene() {
        return new Scene(
                new ImageFormat(160, 120, 0, false),
                Camera.orthographic(new Point(0, 0, 9), new Point(0, 0, 0), new Point(0, 1, 0), 3),
                BLACK);
    }

    private static void add(Instances instances, double x, int rgba) {
        instances
                .position(x, 0, 0)
                .orientation(0, 0, 0, 1)
                .size(1, 0.5, 1)
                .colour(rgba)
                .flags(Instances.UNLIT)
                .item(0);
    }

    private static Scene redBox() {
        Scene scene = scene();
        add(scene.instances(Shape.BOX), 0.5, RED);
        return scene;
    }

    /** A folder with a shell script in place of the renderer. */
    private Path script(String body) throws IOException {
        Path script = folder.resolve("vesper-render");
        Files.writeString(script, "#!/bin/sh\n" + body + "\n");
        Files.setPosixFilePermissions(script, PosixFilePermissions.fromString("rwx------"));
        return folder;
    }

    @Test
    void columnsArriveAsThePicture() {
        Scene scene = redBox();
        add(scene.instances(Shape.SPHERE), -1, BLUE);
        scene.segments(4).from(-2, 1, 0).to(2, 1, 0).colour(Colour.parse("#00ff00").rgba()).item(0);
        Picture picture = Picture.decode(renderer.render(scene));
        assertThat(picture.image().getWidth()).isEqualTo(160);
        assertThat(picture.image().getHeight()).isEqualTo(120);
        assertThat(picture.count(colour -> colour == 0xff0000)).isEqualTo(40 * 20);
        assertThat(picture.count(colour -> colour == 0x00ff00)).isEqualTo(160 * 4);
        assertThat((double) picture.count(colour -> colour == 0x0000ff))
                .isCloseTo(Math.PI * 20 * 10, within(30.0));
        assertThat(picture.at(100, 60)).isEqualTo(0xff0000);
        assertThat(picture.at(40, 60)).isEqualTo(0x0000ff);
        assertThat(picture.at(10, 20)).isEqualTo(0x00ff00);
    }

    @Test
    void moreItemsThanTheFirstRoomAreAllShown() {
        Scene scene =
                new Scene(
                        new ImageFormat(400, 120, 0, false),
                        Camera.orthographic(
                                new Point(0, 0, 9), new Point(0, 0, 0), new Point(0, 1, 0), 3),
                        BLACK);
        for (int i = 0; i < 5000; i++) {
            scene.instances(Shape.BOX)
                    .position((i % 100 - 49.5) * 0.1, (i / 100 - 24.5) * 0.05, 0)
                    .orientation(0, 0, 0, 1)
                    .size(0.1, 0.05, 0.1)
                    .colour(RED)
                    .flags(Instances.UNLIT)
                    .item(0);
        }
        Picture picture = Picture.decode(renderer.render(scene));
        assertThat(picture.count(colour -> colour == 0xff0000)).isEqualTo(400 * 100);
    }

    @Test
    void meshesComeAndGoFromPictureToPicture() {
        var square =
                new Mesh(
                        new float[] {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0},
                        new int[] {0, 1, 2, 0, 2, 3});
        var half = new Mesh(new float[] {-1, -1, 0, 1, -1, 0, 1, 1, 0}, new int[] {0, 1, 2});
        Scene squares = scene();
        squares.instances(square)
                .position(0, 0, 0)
                .orientation(0, 0, 0, 1)
                .size(1, 1, 1)
                .colour(RED)
                .flags(Instances.UNLIT)
                .item(0);
        Scene both = scene();
        both.instances(half)
                .position(-1, 0, 0)
                .orientation(0, 0, 0, 1)
                .size(0.5, 0.5, 1)
                .colour(BLUE)
                .flags(Instances.UNLIT)
                .item(0);
        both.instances(square)
                .position(1, 0, 0)
                .orientation(0, 0, 0, 1)
                .size(0.5, 0.5, 1)
                .colour(RED)
                .flags(Instances.UNLIT)
                .item(0);
        byte[] first = renderer.render(squares);
        assertThat(Picture.decode(first).count(colour -> colour == 0xff0000)).isEqualTo(80 * 80);
        Picture two = Picture.decode(renderer.render(both));
        assertThat(two.count(colour -> colour == 0xff0000)).isEqualTo(40 * 40);
        assertThat(two.count(colour -> colour == 0x0000ff)).isBetween(760L, 840L);
        renderer.render(redBox());
        assertThat(renderer.render(squares)).isEqualTo(first);
    }

    @Test
    void aFileHoldsWhatTheAnswerWouldHold() throws IOException {
        Path file = folder.resolve("red box.png");
        renderer.render(redBox(), file);
        assertThat(Files.readAllBytes(file)).isEqualTo(renderer.render(redBox()));
        assertThat(folder).isDirectoryContaining(path -> path.equals(file));
    }

    @Test
    void aFileThatCannotBeWrittenLeavesTheProcessRunning() {
        renderer.render(redBox());
        long pid = renderer.pid();
        assertThatExceptionOfType(RenderException.class)
                .isThrownBy(() -> renderer.render(redBox(), folder.resolve("no/such/x.png")))
                .withMessageContaining("no/such/x.png")
                .withMessageContaining("No such file");
        renderer.render(redBox());
        assertThat(renderer.pid()).isEqualTo(pid);
    }

    @Test
    void aSceneThatCannotBeDrawnIsRefusedWithItsReasonAndTheNextOneDrawn() {
        Scene broken = redBox();
        add(broken.instances(Shape.BOX), Double.NaN, RED);
        assertThatExceptionOfType(RenderException.class)
                .isThrownBy(() -> renderer.render(broken))
                .withMessageContaining("position of row 1 is not finite");
        assertThat(renderer.render(redBox())).isNotEmpty();
    }

    @Test
    void aLargeSceneRefusedEarlyStillTellsTheReason() {
        Scene broken = scene();
        for (int i = 0; i < 20_000; i++) {
            add(broken.instances(Shape.SPHERE), i == 0 ? 1e30 : 0, RED);
            add(broken.instances(Shape.BOX), 0, RED);
        }
        assertThatExceptionOfType(RenderException.class)
                .isThrownBy(() -> renderer.render(broken))
                .withMessageContaining("position of row 0 is not finite, or beyond 1e15");
    }

    @Test
    void aRowThatLacksAValueIsNotSent() {
        Scene incomplete = redBox();
        incomplete.instances(Shape.BOX).position(0, 0, 0);
        assertThatIllegalStateException()
                .isThrownBy(() -> renderer.render(incomplete))
                .withMessageContaining("has 1 rows, the first one has 2");
        assertThat(renderer.pid()).isEqualTo(-1);
    }

    @Test
    void aProcessThatDiedIsReplaced() {
        byte[] before = renderer.render(redBox());
        long pid = renderer.pid();
        ProcessHandle process = ProcessHandle.of(pid).orElseThrow();
        process.destroyForcibly();
        process.onExit().join();
        assertThat(renderer.render(redBox())).isEqualTo(before);
        assertThat(renderer.pid()).isPositive().isNotEqualTo(pid);
    }

    @Test
    void aProgramThatKeepsDyingIsReportedWithItsLastWords() throws IOException {
        try (var broken =
                new Renderer(
                        script("echo no driver here >&2; exit 4"), Renderer.DEFAULT_DEADLINE)) {
            assertThatExceptionOfType(RenderException.class)
                    .isThrownBy(() -> broken.render(redBox()))
                    .withMessageContaining("ended with exit code 4 and said: no driver here");
        }
    }

    @Test
    void aProgramThatStopsAnsweringIsEnded() throws IOException {
        try (var mute =
                new Renderer(
                        script(
                                "echo $$ >> pids; exec >&-; read line"
                                        .replace("pids", folder.resolve("pids").toString())),
                        Renderer.DEFAULT_DEADLINE)) {
            assertThatExceptionOfType(RenderException.class)
                    .isThrownBy(() -> mute.render(redBox()))
                    .withMessageContaining("in 2 attempts: vesper-render stopped answering");
        }
        for (String pid : Files.readAllLines(folder.resolve("pids"))) {
            ProcessHandle.of(Long.parseLong(pid)).ifPresent(left -> left.onExit().join());
        }
    }

    @Test
    void aProgramThatNeverAnswersIsEndedAtTheDeadline() throws IOException {
        try (var hung = new Renderer(script("exec tail -f /dev/null"), Duration.ofMillis(200))) {
            assertThatExceptionOfType(RenderException.class)
                    .isThrownBy(() -> hung.render(redBox()))
                    .withMessageContaining("no picture within 200 ms");
            assertThat(hung.pid()).isEqualTo(-1);
        }
    }

    @Test
    void closingEndsThePictureBeingMade() throws IOException {
        var hung = new Renderer(script("exec tail -f /dev/null"), Renderer.DEFAULT_DEADLINE);
        var picture = CompletableFuture.supplyAsync(() -> hung.render(redBox()));
        while (hung.pid() < 0 && !picture.isDone()) {
            Thread.onSpinWait();
        }
        hung.close();
        assertThatThrownBy(picture::join)
                .hasCauseInstanceOf(RenderException.class)
                .hasMessageContaining("was closed");
        assertThatExceptionOfType(RenderException.class)
                .isThrownBy(() -> hung.render(redBox()))
                .withMessageContaining("was closed");
    }

    @Test
    void aMissingProgramIsNamed() {
        try (var missing = new Renderer(folder.resolve("nowhere"), Renderer.DEFAULT_DEADLINE)) {
            assertThatExceptionOfType(RenderException.class)
                    .isThrownBy(() -> missing.render(redBox()))
                    .withMessageContaining("nowhere/vesper-render")
                    .withMessageContaining("build it");
        }
    }
}
