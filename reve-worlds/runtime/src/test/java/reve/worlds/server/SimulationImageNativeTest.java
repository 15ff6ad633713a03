// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;
import static org.assertj.core.api.Assertions.catchThrowable;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.MethodSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Item;
import reve.core.world.WorldSnapshot;
import reve.worlds.journal.SimulationImage;

import java.io.IOException;
import java.lang.foreign.ValueLayout;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.stream.Stream;

/** Rewinds and previews, with contacts that laws remember. */
class SimulationImageNativeTest {
    private static final int FRAMES = 60;
    private static final Path WORLDS = Path.of(System.getProperty("reve.root"), "worlds");

    private Simulation live;

    @BeforeEach
    void run() throws Exception {
        WorldDescription description = WorldFile.load(WORLDS.resolve("icosahedron/world.yaml"));
        live = new Simulation(description, Pacing.FAST);
        live.loop().run(2 * FRAMES);
    }

    @AfterEach
    void close() {
        live.close();
    }

    @Test
    void afterARewindTheSameHappensAgain() {
        try (SimulationImage image = live.keep()) {
            List<Long> first = hashes(live, FRAMES);
            live.world().find("c3").orElseThrow().physics().set("velocity", 0, 9, 0);
            live.loop().step();

            long frame = live.rewind(image);

            assertThat(frame).isEqualTo(3 * FRAMES + 2);
            assertThat(live.loop().frame()).isEqualTo(frame);
            assertThat(hashes(live, FRAMES)).isEqualTo(first);
        }
    }

    static Stream<Path> shippedWorlds() throws IOException {
        try (Stream<Path> folders = Files.list(WORLDS)) {
            return folders
                    .map(folder -> folder.resolve("world.yaml"))
                    .filter(Files::exists)
                    .sorted()
                    .toList()
                    .stream();
        }
    }

    @ParameterizedTest
    @MethodSource("shippedWorlds")
    void everyShippedWorldContinuesFromItsImage(Path file) throws Exception {
        WorldDescription description = WorldFile.load(file);
        LawPath laws = LawPath.ofShipped();
        try (Simulation whole = new Simulation(description, Pacing.FAST, laws)) {
            whole.loop().run(5);
            try (SimulationImage image = whole.keep();
                    Simulation continued = new Simulation(description, Pacing.FAST, laws, image)) {
                assertThat(hashes(continued, 3)).isEqualTo(hashes(whole, 3));
            }
        }
    }

    @Test
    void aForkRunsAheadOnAnotherThreadAndTheLiveWorldDoesNotNotice() throws Exception {
        List<Long> undisturbed;
        try (SimulationImage image = live.keep()) {
            undisturbed = hashes(live, FRAMES);
            live.rewind(image);
            List<Long> foreseen = new ArrayList<>();
            double[] pushed = new double[1];
            Thread seer =
                    Thread.ofPlatform()
                            .start(
                                    () -> {
                                        try (Simulation fork = live.fork(image);
                                                Simulation push = live.fork(image)) {
                                            foreseen.addAll(hashes(fork, FRAMES));
                                            push.world().guard().claim();
                                            push.world()
                                                    .find("c3")
                                                    .orElseThrow()
                                                    .physics()
                                                    .set("velocity", 0, 50, 0);
                                            push.loop().run(FRAMES);
                                            pushed[0] = height(push);
                                        }
                                    });
            List<Long> lived = hashes(live, FRAMES);
            seer.join();
            assertThat(lived).isEqualTo(undisturbed);
            assertThat(foreseen).isEqualTo(undisturbed);
            assertThat(pushed[0]).isGreaterThan(height(live) + 0.5);
        }
    }

    @Test
    void theNextFrameShowsTheWorldAsItWas() {
        try (SimulationImage image = live.keep()) {
            live.loop().run(5);
            live.rewind(image);
            live.loop().run(0);
            try (WorldSnapshot snapshot = live.snapshots().acquireLatest().orElseThrow()) {
                assertThat(snapshot.frame()).isEqualTo(2 * FRAMES + 6);
                assertThat(snapshot.timeSeconds()).isEqualTo(2.0);
            }
        }
    }

    /**
     * The image is taken before the rule reads the new number. After the rewind, the world has the
     * number that the rule read last.
     */
    @Test
    void whatARuleSaysFollowsFromWhatTheRewoundWorldIs() throws Exception {
        byte[] text =
                """
                reve: 1
                name: slide
                rules: {fast: "norm(physics.velocity) > 1.0"}
                items: [{name: puck, physics: {mass: 1}}]
                """
                        .getBytes(StandardCharsets.UTF_8);
        try (Simulation slide = new Simulation(WorldFile.parse("slide", text), Pacing.FAST)) {
            slide.loop().run(1);
            Item puck = slide.world().find("puck").orElseThrow();
            puck.physics().set("velocity", 9, 0, 0);
            try (SimulationImage image = slide.keep()) {
                slide.loop().step();
                assertThat(puck.semantic().get("fast")).contains(true);

                slide.rewind(image);
                slide.loop().run(0);

                assertThat(puck.semantic().get("fast")).contains(true);
            }
        }
    }

    @Test
    void lawsOfALaterTimeGo() {
        try (SimulationImage image = live.keep()) {
            List<String> before = laws(live);
            live.physics().laws().load(live.loop().frame(), "drag", Map.of());
            live.loop().run(2);
            live.rewind(image);
            assertThat(laws(live)).isEqualTo(before);
            try (Simulation fork = live.fork(image)) {
                assertThat(laws(fork)).isEqualTo(before);
            }
        }
    }

    @Test
    void imagesAreBoundedAndEndWithTheirSimulation() {
        SimulationImage first = live.keep();
        for (int i = 1; i < 64; i++) {
            live.keep();
        }
        assertThatIllegalStateException()
                .isThrownBy(live::keep)
                .withMessageContaining("64 images")
                .withMessageContaining("close one first");
        first.close();
        SimulationImage last = live.keep();
        live.close();
        assertThat(
                        catchThrowable(
                                () ->
                                        last.world()
                                                .tables()
                                                .getFirst()
                                                .column(0)
                                                .get(ValueLayout.JAVA_BYTE, 0)))
                .isInstanceOf(IllegalStateException.class);
    }

    private static List<Long> hashes(Simulation simulation, int frames) {
        List<Long> hashes = new ArrayList<>();
        for (int i = 0; i < frames; i++) {
            simulation.loop().step();
            hashes.add(simulation.physics().stateHash());
        }
        return hashes;
    }

    private static List<String> laws(Simulation simulation) {
        return simulation.physics().laws().loaded().stream().map(law -> law.name()).toList();
    }

    /** Returns the height of corner c3 in the last snapshot [m]. */
    private static double height(Simulation simulation) {
        try (WorldSnapshot snapshot = simulation.snapshots().acquireLatest().orElseThrow()) {
            var bodies = snapshot.table("body");
            int row =
                    bodies.rowOf(
                            snapshot.symbols().values().stream()
                                    .filter(item -> item.name().equals("c3"))
                                    .findFirst()
                                    .orElseThrow()
                                    .id());
            return bodies.column("position").getDouble(row, 1);
        }
    }
}
