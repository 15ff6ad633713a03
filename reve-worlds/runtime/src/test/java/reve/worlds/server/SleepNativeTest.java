// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Item;
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

/** Worlds in which bodies at rest sleep: edits, rules, recordings, images and forks. */
class SleepNativeTest {
    /**
     * The tower stands on a pedestal, and the stool beside it has a leg as a part. The ball rolls
     * far away.
     */
    private static final String WORLD =
            """
            reve: 1
            name: sleepy
            frame: {rate: 60, steps: 2}
            laws: [gravity_field, {name: rigid_contact, parameters: {sleepTime: 0.5 s}}]
            constants: {gravity: [0, -9.81, 0]}
            rules:
              dreams: physics.asleep == 1
            items:
              - {name: ground, physical: {shape: box, size: [90, 1, 90], location: [0, -0.5, 0]}}
              - name: pedestal
                physical: {shape: box, size: [2, 1, 2], location: [0, 0.5, 0]}
                physics: {mass: 0}
              - name: brick {i}
                repeat: 3
                physical: {shape: box, size: [1, 1, 1], location: "{[0, 1.5 + i, 0]}"}
                physics: {mass: 2 kg, asleep: 0}
              - name: stool
                physical: {shape: box, size: [0.5, 0.1, 0.5], location: [4.1, 0.552, 4.3], orientation: [0, 0.6, 0, 0.8]}
                physics: {mass: 4 kg}
              - name: leg
                parent: stool
                physical: {shape: cylinder, radius: 0.1, height: 0.5, location: [0, -0.3, 0]}
                physics: {partOfBody: 1}
              - name: ball
                physical: {shape: sphere, radius: 0.5 m, location: [20, 0.5, 0]}
                physics: {mass: 1 kg, velocity: [0, 0, 1]}
            """;

    @TempDir private Path folder;

    private static WorldDescription world() throws Exception {
        return WorldFile.parse("sleepy.yaml", WORLD.getBytes(StandardCharsets.UTF_8));
    }

    private static Item item(Simulation simulation, String name) {
        return simulation.world().find(name).orElseThrow();
    }

    private static boolean sleeps(Simulation simulation, String name) {
        return item(simulation, name).physics().scalar("asleep") == 1;
    }

    private static List<Long> hashes(Simulation simulation, int frames) {
        List<Long> hashes = new ArrayList<>();
        for (int frame = 0; frame < frames; frame++) {
            simulation.loop().step();
            hashes.add(simulation.physics().stateHash());
        }
        return hashes;
    }

    @Test
    void bodiesSleepUntilTheirSupportIsRemoved() throws Exception {
        try (Simulation simulation = new Simulation(world(), Pacing.FAST)) {
            assertThat(simulation.warnings(true)).isEmpty();
            simulation.loop().run(120);
            for (String name : List.of("brick 0", "brick 1", "brick 2", "stool", "leg")) {
                assertThat(sleeps(simulation, name)).as(name).isTrue();
            }
            assertThat(sleeps(simulation, "ball")).isFalse();
            assertThat(item(simulation, "brick 1").semantic().get("dreams")).contains(true);
            double[] stool = item(simulation, "stool").physical().location();
            simulation.loop().run(60);
            assertThat(item(simulation, "stool").physical().location()).isEqualTo(stool);
            assertThat(sleeps(simulation, "leg")).as("its place has other rounding").isTrue();

            simulation.world().remove(item(simulation, "pedestal").id());
            simulation.loop().run(60);
            assertThat(item(simulation, "brick 0").physical().location()[1]).isBetween(0.45, 0.51);
            assertThat(item(simulation, "stool").physical().location()[1]).isEqualTo(stool[1]);
        }
    }

    @Test
    void editsOfItemsAndConstantsWake() throws Exception {
        try (Simulation simulation = new Simulation(world(), Pacing.FAST)) {
            simulation.loop().run(120);
            item(simulation, "brick 2").physical().setLocation(0, 3.6, 0);
            simulation.loop().step();
            assertThat(sleeps(simulation, "brick 0")).isFalse();
            assertThat(sleeps(simulation, "stool")).isTrue();
            simulation.loop().run(120);
            assertThat(sleeps(simulation, "brick 0")).isTrue();
            item(simulation, "leg").physical().setLocation(0, -0.4, 0);
            simulation.loop().step();
            assertThat(sleeps(simulation, "stool")).isFalse();
            assertThat(sleeps(simulation, "brick 0")).isTrue();
            item(simulation, "world").physics().set("gravity", 1, -9.81, 0);
            simulation.loop().step();
            assertThat(sleeps(simulation, "brick 0")).isFalse();
        }
    }

    @Test
    void aRecordingIsRepeatedToTheBitAlsoAfterARewindAndAnEdit() throws Exception {
        Path log = folder.resolve("run.log");
        long hash;
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
            simulation.loop().run(45);
            SimulationImage image = simulation.keep();
            simulation.loop().run(75);
            assertThat(sleeps(simulation, "brick 0")).isTrue();
            simulation.rewind(image);
            simulation.loop().run(80);
            assertThat(sleeps(simulation, "brick 0")).isTrue();
            item(simulation, "brick 1").physics().set("velocity", 0.5, 0, 0);
            simulation.loop().run(40);
            hash = simulation.physics().stateHash();
        }
        try (Replay replay = replay(log);
                Simulation again = replay.release()) {
            assertThat(replay.divergence()).isEmpty();
            assertThat(again.physics().stateHash()).isEqualTo(hash);
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
        for (int frames : new int[] {20, 100}) {
            try (Simulation whole = new Simulation(world(), Pacing.FAST)) {
                whole.loop().run(frames);
                try (SimulationImage image = whole.keep();
                        Simulation fork = whole.fork(image);
                        Simulation resumed =
                                new Simulation(world(), Pacing.FAST, LawPath.ofShipped(), image)) {
                    for (Simulation one : List.of(whole, fork, resumed)) {
                        item(one, "stool").physics().set("velocity", 0, 1, 0);
                    }
                    List<Long> expected = hashes(whole, 90);
                    assertThat(hashes(resumed, 90)).isEqualTo(expected);
                    assertThat(hashes(fork, 90)).isEqualTo(expected);
                    assertThat(sleeps(whole, "brick 0")).isTrue();
                }
            }
        }
    }
}
