// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Encoding;
import reve.agent.Image;
import reve.agent.Join;
import reve.agent.LockStep;

import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.Map;

/** Pictures of a body's camera, drawn by the real renderer. */
@Tag("slow")
class CameraIT {
    private static final int SIDE = 101;
    private static final double FIELD = Math.toRadians(60);

    @TempDir private Path folder;

    /**
     * A world in which the robot looks along +z at a ball. The ball is in front of a wall that is
     * out of range, and a cube is behind the robot.
     */
    private String world() throws Exception {
        return Files.writeString(
                        folder.resolve("world.yaml"),
                        """
                        reve: 1
                        name: gallery
                        laws: [newton_motion]
                        agents: {bodies: [robot]}
                        items:
                          - name: robot
                            physical: {shape: sphere, radius: 0.5}
                            physics: {mass: 1 kg, velocity: [0, 0, 0.6]}
                            sensors:
                              eye: {camera: {size: [101, 101], layers: [colour, depth, items]}, fieldOfView: 60 deg, range: 10 m}
                          - {name: ball, physical: {shape: sphere, radius: 0.5, colour: "#ff0000", location: [0, 0, 4]}}
                          - {name: post, physical: {shape: box, size: [0.4, 9, 0.4], location: [1.5, 0, 5]}}
                          - {name: wall, physical: {shape: box, size: [90, 90, 1], location: [0, 0, 30]}}
                          - {name: hidden, physical: {shape: box, size: [0.2, 0.2, 0.2], location: [0, 0, 8]}}
                          - {name: behind, physical: {shape: box, size: [1, 1, 1], location: [0, 0, -4]}}
                        """)
                .toString();
    }

    private Server serve() throws Exception {
        return Server.start(
                folder,
                "serve",
                world(),
                "--port",
                "0",
                "--json",
                "--deadline",
                "300",
                "--waiting",
                "off");
    }

    private static AgentClient join(Server server, Encoding encoding) throws Exception {
        return Agents.join(
                Integer.parseInt(server.port()),
                Join.as("ada")
                        .withEncoding(encoding)
                        .withLockStep(LockStep.every(1).withDeadline(Duration.ofSeconds(300))));
    }

    private static float depth(Image image, int x, int y) {
        return image.depth().orElseThrow().getFloat(4 * (y * SIDE + x));
    }

    @Test
    void aPictureShowsWhatIsBeforeTheCameraWithItsDistanceAndItsName() throws Exception {
        try (Server server = serve();
                AgentClient ada = join(server, Encoding.MESSAGEPACK)) {
            Image image = ada.look("eye");
            assertThat(image.names()).containsExactlyInAnyOrder("ball", "post");
            assertThat(image.find(SIDE / 2, SIDE / 2)).contains("ball");
            assertThat(image.find(0, SIDE / 2)).isEmpty();
            // Seen from the robot, +x is on the left.
            int post = (int) Math.round(SIDE / 2.0 - 1.5 / 5 / Math.tan(FIELD / 2) * SIDE / 2);
            assertThat(image.find(post, 10)).contains("post");
            assertThat(image.find(SIDE - post, 10)).isEmpty();

            double distance = 4 - 0.6 * image.time();
            assertThat(depth(image, SIDE / 2, SIDE / 2))
                    .isCloseTo((float) (distance - 0.5), within(3e-3f));
            assertThat(depth(image, 0, SIDE / 2)).as("the wall is out of range").isZero();
            long ball = 0;
            for (int pixel = 0; pixel < SIDE * SIDE; pixel++) {
                var found = image.find(pixel % SIDE, pixel / SIDE);
                ball += found.filter("ball"::equals).isPresent() ? 1 : 0;
            }
            double disc = Math.tan(Math.asin(0.5 / distance)) / Math.tan(FIELD / 2) * SIDE / 2;
            assertThat(Math.sqrt(ball / Math.PI)).isCloseTo(disc, within(0.5));
            ByteBuffer colour = image.colour().orElseThrow();
            int centre = 3 * (SIDE / 2 * SIDE + SIDE / 2);
            assertThat(Byte.toUnsignedInt(colour.get(centre)))
                    .isGreaterThan(2 * Byte.toUnsignedInt(colour.get(centre + 1)));
            assertThat(colour.get(0)).as("out of range is black").isZero();
        }
    }

    /** Returns the robot's picture of the world in its first frame. */
    private Image atTheBeginning(Encoding encoding) throws Exception {
        try (Server server = serve();
                AgentClient ada = join(server, encoding);
                AgentClient boss =
                        Agents.join(
                                Integer.parseInt(server.port()),
                                Join.as("boss").withRole("control"))) {
            assertThat(boss.command("rewind", Map.of()).accepted()).isTrue();
            return ada.look("eye");
        }
    }

    @Test
    void theSameWorldIsSeenTheSameByEveryServerInBothEncodings() throws Exception {
        Image packed = atTheBeginning(Encoding.MESSAGEPACK);
        Image text = atTheBeginning(Encoding.JSON);
        assertThat(packed.time()).isZero();
        assertThat(text.time()).isZero();
        assertThat(text.names()).isEqualTo(packed.names());
        assertThat(text.colour()).isEqualTo(packed.colour());
        assertThat(text.depth()).isEqualTo(packed.depth());
        assertThat(text.items()).isEqualTo(packed.items());
    }

    @Test
    void aRendererThatDiesCostsNobodyAnything() throws Exception {
        try (Server server = serve();
                AgentClient ada = join(server, Encoding.MESSAGEPACK)) {
            Image before = ada.look("eye");
            var renderers =
                    server.process()
                            .descendants()
                            .filter(
                                    process ->
                                            process.info()
                                                    .command()
                                                    .orElse("")
                                                    .endsWith("vesper-render"))
                            .toList();
            assertThat(renderers).hasSize(1);
            renderers.forEach(ProcessHandle::destroyForcibly);
            Image after = ada.look("eye");
            assertThat(after.frame()).isEqualTo(before.frame());
            assertThat(after.colour()).isEqualTo(before.colour());
        }
    }

    /** Number of crashes of the renderer. The fault model requires 200. */
    private static final int CRASHES = Integer.getInteger("reve.test.renderer.crashes", 3);

    /** Maximum time of a picture after a crash; 2,000 on an idle machine [ms]. */
    private static final int PICTURE_MILLISECONDS =
            Integer.getInteger("reve.test.renderer.milliseconds", 300_000);

    /** Least speed of the world as a percentage of real time; 95 on an idle machine. */
    private static final int LEAST_PERCENT = Integer.getInteger("reve.test.renderer.percent", 50);

    /** Number of runs of which one must have the least speed: a busy machine may pause. */
    private static final int RUNS = 3;

    /** The world makes its frames in real time while the renderer crashes. */
    @Test
    void aRendererThatCrashesAgainAndAgainDelaysNoFrame() throws Exception {
        Path still = Path.of(world());
        Files.writeString(still, Files.readString(still).replace("0.6]", "0]"));
        double percent = 0;
        for (int i = 0; i < RUNS && percent <= LEAST_PERCENT; i++) {
            percent = percentWhileTheRendererCrashes(still.toString());
        }
        assertThat(percent).as("% of real time").isGreaterThan(LEAST_PERCENT);
    }

    /** Returns the speed of a world whose renderer crashes, as a percentage of real time. */
    private double percentWhileTheRendererCrashes(String world) throws Exception {
        try (Server server = Server.start(folder, "serve", world, "--port", "0", "--json");
                AgentClient ada =
                        Agents.join(
                                Integer.parseInt(server.port()),
                                Join.as("ada").withEncoding(Encoding.MESSAGEPACK))) {
            Image image = ada.look("eye");
            for (int crash = 0; crash < CRASHES; crash++) {
                ProcessHandle renderer =
                        server.process()
                                .descendants()
                                .filter(
                                        process ->
                                                process.info()
                                                        .command()
                                                        .orElse("")
                                                        .endsWith("vesper-render"))
                                .findFirst()
                                .orElseThrow();
                assertThat(
                                new ProcessBuilder("kill", "-SEGV", "" + renderer.pid())
                                        .start()
                                        .waitFor())
                        .isZero();
                renderer.onExit().join();
                long start = System.nanoTime();
                Image next = ada.look("eye");
                assertThat((System.nanoTime() - start) / 1_000_000)
                        .as("time of a picture [ms]")
                        .isLessThan(PICTURE_MILLISECONDS);
                assertThat(next.frame()).isGreaterThan(image.frame());
                assertThat(next.names()).contains("post");
                image = next;
            }
            server.process().toHandle().destroy();
            var end = server.events().await("end", event -> true);
            assertThat(end.path("frames").asLong()).isGreaterThanOrEqualTo(image.frame());
            assertThat(end.path("faults")).isEmpty();
            return 100 * end.path("realTimeFactor").asDouble();
        }
    }
}
