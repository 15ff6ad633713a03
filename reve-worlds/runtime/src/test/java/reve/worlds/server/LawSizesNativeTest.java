// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Shape;
import reve.core.world.WorldChange;
import reve.core.world.WorldSnapshot;
import reve.worlds.journal.Journal;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.SimulationImage;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Worlds in which a law changes sizes: boxes, rules, recordings, images, forks and saved worlds.
 */
class LawSizesNativeTest {
    private static final int FRAMES = 60;

    /** The ball's diameter grows from 1 m by 0.2 m/s. The rule compares it with 1.1 m. */
    private static final String WORLD =
            """
            reve: 1
            name: growing
            frame: {rate: 60, steps: 2}
            laws:
              - gravity_field
              - rigid_contact
              - text: |
                  law grow "Balls of a growing class grow."
                    parameter v = 0.2 m/s
                    each body has growing
                    each body: size += growing v dt (1, 1, 1)
            constants: {gravity: [0, -9.81, 0]}
            properties:
              - {name: growing, kind: body}
            rules:
              large: {is: "physical.size[0] > 1.1", class: balloon}
            items:
              - {name: ground, physical: {shape: box, size: [9, 1, 9], location: [0, -0.5, 0]}}
              - name: ball
                physical: {shape: sphere, radius: 0.5 m, location: [0, 0.5, 0]}
                semantic: {class: balloon}
                physics: {mass: 1 kg, growing: 1}
              - name: lid
                physical: {shape: box, size: [1, 0.2, 1], location: [0, 1.1, 0]}
                physics: {mass: 1 kg}
            """;

    @TempDir private Path folder;

    private static WorldDescription world() throws Exception {
        return WorldFile.parse("growing.yaml", WORLD.getBytes(StandardCharsets.UTF_8));
    }

    private static double diameter(Simulation simulation) {
        Shape shape = simulation.world().find("ball").orElseThrow().physical().shape();
        return 2 * ((Shape.Sphere) shape).radius();
    }

    private static List<Long> hashes(Simulation simulation) {
        List<Long> hashes = new ArrayList<>();
        for (int frame = 0; frame < FRAMES; frame++) {
            simulation.loop().step();
            hashes.add(simulation.physics().stateHash());
        }
        return hashes;
    }

    @Test
    void boxesSnapshotsAndRulesFollowInTheSameFrame() throws Exception {
        try (Simulation simulation = new Simulation(world(), Pacing.FAST)) {
            assertThat(simulation.warnings(true)).isEmpty();
            List<Boolean> large = new ArrayList<>();
            List<WorldChange> changes = new ArrayList<>();
            simulation.onPublish("changes", frame -> changes.addAll(frame.world().changes()));
            for (int frame = 1; frame <= FRAMES; frame++) {
                simulation.loop().step();
                double expected = 1 + 0.2 * frame / 60;
                assertThat(diameter(simulation)).isCloseTo(expected, within(1e-12));
                var ball = simulation.world().find("ball").orElseThrow();
                for (int axis = 0; axis < 3; axis++) {
                    assertThat(
                                    ball.physical().boundsMax()[axis]
                                            - ball.physical().boundsMin()[axis])
                            .isCloseTo(expected, within(1e-9));
                }
                large.add((Boolean) ball.semantic().get("large").orElseThrow());
                try (WorldSnapshot snapshot =
                        simulation.snapshots().acquireLatest().orElseThrow()) {
                    assertThat(snapshot.symbols().get(ball.id()).shape())
                            .isEqualTo(ball.physical().shape());
                    assertThat(snapshot.table("body").column("size").getDouble(0, 0))
                            .isEqualTo(diameter(simulation));
                }
            }
            assertThat(large.indexOf(true)).isBetween(29, 30);
            assertThat(changes)
                    .noneMatch(
                            change ->
                                    change instanceof WorldChange.Edited edited
                                            && edited.aspect() == WorldChange.Aspect.PHYSICAL);
            // The ball overlaps the ground and the lid by about 0.02 m while it grows.
            assertThat(simulation.world().find("lid").orElseThrow().physical().location()[1])
                    .isCloseTo(1.3, within(0.025));
        }
    }

    @Test
    void aTextChangesSizesInAWorldOfSinglePrecision() throws Exception {
        WorldDescription single =
                WorldFile.parse(
                        "growing.yaml",
                        WORLD.replace("name: growing\n", "name: growing\nprototype: si-f32\n")
                                .getBytes(StandardCharsets.UTF_8));
        try (Simulation simulation = new Simulation(single, Pacing.FAST);
                Simulation again = new Simulation(single, Pacing.FAST)) {
            assertThat(simulation.warnings(true)).isEmpty();
            assertThat(hashes(simulation)).isEqualTo(hashes(again));
            assertThat(diameter(simulation)).isCloseTo(1.2, within(1e-5));
            assertThat(simulation.world().find("lid").orElseThrow().physical().shape())
                    .as("does not grow")
                    .isEqualTo(Shape.box(1, 0.2, 1));
        }
    }

    @Test
    void aRecordingIsRepeatedToTheBitAlsoAfterARewindAndAnEdit() throws Exception {
        Path log = folder.resolve("run.log");
        long hash;
        double end;
        try (Simulation simulation = new Simulation(world(), Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                })) {
            simulation.loop().run(20);
            SimulationImage image = simulation.keep();
            simulation.loop().run(20);
            simulation.rewind(image);
            assertThat(diameter(simulation)).isCloseTo(1 + 0.2 / 3, within(1e-12));
            simulation.world().find("ball").orElseThrow().physical().setShape(Shape.sphere(0.7));
            simulation.loop().run(30);
            hash = simulation.physics().stateHash();
            end = diameter(simulation);
            assertThat(end).isCloseTo(1.5, within(1e-12));
        }
        try (Replay replay = replay(log);
                Simulation again = replay.release()) {
            assertThat(replay.divergence()).isEmpty();
            assertThat(again.physics().stateHash()).isEqualTo(hash);
            assertThat(diameter(again)).isEqualTo(end);
        }
    }

    private static Replay replay(Path file) throws IOException {
        Replay replay = new Replay(Optional.empty(), Pacing.FAST);
        try (RunLog.Reader records = RunLog.open(file)) {
            while (records.hasNext() && replay.take(records.next())) {
                // the list stays open for further records
            }
        }
        return replay;
    }

    @Test
    void imagesAndForksContinueToTheBit() throws Exception {
        try (Simulation whole = new Simulation(world(), Pacing.FAST)) {
            whole.loop().run(20);
            try (SimulationImage image = whole.keep();
                    Simulation fork = whole.fork(image);
                    Simulation resumed =
                            new Simulation(world(), Pacing.FAST, LawPath.ofShipped(), image)) {
                List<Long> expected = hashes(whole);
                assertThat(hashes(resumed)).isEqualTo(expected);
                assertThat(hashes(fork)).isEqualTo(expected);
                assertThat(diameter(fork)).isEqualTo(diameter(whole));
            }
        }
    }

    @Test
    void aSavedWorldHasTheSizeAndContinues() throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation simulation = new Simulation(world(), Pacing.FAST)) {
            simulation.loop().run(30);
            WorldFile.save(saved, simulation.descriptionNow());
            try (Simulation again = new Simulation(WorldFile.load(saved), Pacing.FAST)) {
                assertThat(diameter(again)).isEqualTo(diameter(simulation));
                again.loop().run(30);
                simulation.loop().run(30);
                assertThat(diameter(again)).isEqualTo(diameter(simulation));
            }
        }
    }
}
