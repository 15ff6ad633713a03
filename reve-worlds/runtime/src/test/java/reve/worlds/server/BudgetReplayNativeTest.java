// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.frame.TimeBudget;
import reve.core.frame.TimeBudget.Response;
import reve.pe.adapter.LawLibrary;
import reve.worlds.journal.Journal;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;

import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * Decisions that depended on the clock. The test compares them in a recording and in its replay,
 * which has no clock.
 */
class BudgetReplayNativeTest {
    private static final int FRAMES = 60;
    private static final int SET = 20;

    private static final String WORLD =
            """
            reve: 1
            name: budgets
            frame: {rate: 60, steps: 4}
            laws:
            - name: gravity_field
              budget: {time: 1e-9, frames: 3, then: skip-steps, every: 3}
            - {name: drag, budget: 10 s}
            - newton_motion
            constants: {gravity: [0, -9.81, 0]}
            items:
            - name: ball
              physical: {shape: sphere, radius: 0.1, location: [0, 5, 0]}
              physics: {mass: 1, velocity: [3, 0, 0], dragCoefficient: 0.4}
            """;

    @TempDir private Path folder;

    @Test
    void aReplayTakesTheDecisionsOfTheClockFromTheRecording() throws Exception {
        Path log = folder.resolve("run.log");
        WorldDescription description =
                WorldFile.parse("budgets.yaml", WORLD.getBytes(StandardCharsets.UTF_8));
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                folder,
                                Map.of(),
                                new Journal.Plan(0, true),
                                new Recording(RecordingPlan.of(log)),
                                problem -> {
                                    throw new AssertionError(problem);
                                })) {
            simulation.physics().enforceBudgets(true);
            simulation.loop().run(SET);
            assertThat(library(simulation, "gravity_field").interval()).isEqualTo(3);
            simulation
                    .physics()
                    .laws()
                    .setBudget("drag", Optional.of(new TimeBudget(1, 5, Response.UNLOAD, 2)));
            simulation.loop().run(FRAMES - SET);
            assertThat(names(simulation)).containsExactly("gravity_field", "newton_motion");
            assertThat(simulation.events().count("over-budget")).isGreaterThanOrEqualTo(2);
            hash = simulation.physics().stateHash();
        }
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST);
                RunLog.Reader records = RunLog.open(log)) {
            while (records.hasNext() && replay.take(records.next())) {
                // Replays until the end.
            }
            assertThat(replay.divergence()).isEmpty();
            assertThat(replay.frames()).isEqualTo(FRAMES);
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
                assertThat(again.events().count("over-budget")).isZero();
                assertThat(names(again)).containsExactly("gravity_field", "newton_motion");
                assertThat(library(again, "gravity_field").interval()).isEqualTo(3);
                assertThat(library(again, "gravity_field").budget())
                        .contains(new TimeBudget(1, 3, Response.SKIP_STEPS, 3));
                assertThat(again.notDescribed())
                        .containsExactly(
                                "that the laws of gravity_field are evaluated once in 3 steps");
                assertThat(again.descriptionNow().laws().getFirst().budget())
                        .contains(new TimeBudget(1, 3, Response.SKIP_STEPS, 3));
            }
        }
    }

    private static List<String> names(Simulation simulation) {
        return simulation.physics().laws().libraries().stream().map(LawLibrary::name).toList();
    }

    private static LawLibrary library(Simulation simulation, String name) {
        return simulation.physics().laws().libraries().stream()
                .filter(library -> library.name().equals(name))
                .findFirst()
                .orElseThrow();
    }
}
