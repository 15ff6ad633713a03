// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.WorldEvent;
import reve.worlds.journal.SimulationImage;

import java.lang.management.ManagementFactory;
import java.lang.management.ThreadMXBean;
import java.nio.charset.StandardCharsets;
import java.util.List;
import java.util.stream.IntStream;

/** Worlds whose rules need more steps than a frame has. */
@Timeout(300)
@Tag("slow")
class CostlyRulesNativeTest {
    private static final String NEAR =
            world(
                    """
                    items: [{name: 'a{i}', repeat: 20000, physical: {shape: sphere, radius: 1},
                      physics: {mass: 1}}]
                    rules: {dear: 'semantic.near', cheap: 'physics.mass'}
                    """);
    private static final String NESTED =
            world(
                    """
                    items: [{name: 'a{i}', repeat: 100000, physics: {mass: 1}}]
                    rules: {dear: '[0,1,2,3,4,5,6,7,8,9].all(a,[0,1,2,3,4,5,6,7,8,9].all(b,
                      [0,1,2,3,4,5,6,7,8].all(c,physics.mass>=0.0)))', cheap: 'physics.mass'}
                    """);

    /** A world whose rules take 45,000,000 steps once, and no steps while nothing changes. */
    private static final String MANY =
            world(
                    """
                    items: [{name: 'a{i}', repeat: 10000, physics: {mass: 1}}]
                    rules: {dear: '[0,1,2,3,4,5,6,7,8,9].all(a,[0,1,2,3,4,5,6,7,8,9].all(b,
                      [0,1,2].all(c,physics.mass>=0.0)))', cheap: 'physics.mass'}
                    """);

    private static final String HONEST =
            world(
                    """
                    items: [{name: 'a{i}', repeat: 100000, physics: {mass: 1}}]
                    rules: {%s}
                    """
                            .formatted(
                                    "r0: 'physics.mass * 2.0 + 1.0 > 2.0'"
                                            + String.join(
                                                    "",
                                                    IntStream.range(1, 10)
                                                            .mapToObj(
                                                                    i ->
                                                                            ", r"
                                                                                    + i
                                                                                    + ": 'physics.mass"
                                                                                    + " * 2.0 + 1.0"
                                                                                    + " > 2.0'")
                                                            .toList())));

    private static String world(String text) {
        return "reve: 1\nname: w\nlaws: [newton_motion]\n" + text;
    }

    private static Simulation simulation(String text) throws Exception {
        return new Simulation(
                WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)), Pacing.FAST);
    }

    private static List<WorldEvent> tooManySteps(Simulation simulation) {
        return simulation.events().faults().stream()
                .filter(event -> "TooManySteps".equals(event.fields().get("error")))
                .toList();
    }

    /**
     * Makes frames. The first frame takes 40,000,000 steps. Each later frame takes 200,000 steps,
     * which need less than 100 ms.
     */
    private static void makesFrames(String text) throws Exception {
        try (Simulation simulation = simulation(text)) {
            simulation.loop().run(1);
            ThreadMXBean threads = ManagementFactory.getThreadMXBean();
            long start = threads.getCurrentThreadCpuTime();
            simulation.loop().run(40);

            assertThat(simulation.loop().frame()).isEqualTo(41);
            assertThat(threads.getCurrentThreadCpuTime() - start)
                    .as("processor time [ns]")
                    .isLessThan(40_000_000_000L);
            assertThat(tooManySteps(simulation))
                    .singleElement()
                    .satisfies(
                            event ->
                                    assertThat(event.fields().get("message").toString())
                                            .contains("rule dear took", "at most 40,000,000"));
        }
    }

    /** The rules of all items are evaluated, one part after another. */
    @Test
    void allItemsHaveTheirSymbolsAfterSomeFrames() throws Exception {
        try (Simulation simulation = simulation(MANY)) {
            simulation.loop().run(1);
            var last = simulation.world().find("a9999").orElseThrow().semantic();
            assertThat(last.get("cheap")).isEmpty();

            simulation.loop().run(100);

            assertThat(last.get("dear")).contains(true);
            assertThat(last.get("cheap")).contains(1.0);
        }
    }

    @Test
    void worldMakesFramesWhoseRuleReadsManyNeighbours() throws Exception {
        makesFrames(NEAR);
    }

    @Test
    void worldMakesFramesWhoseRuleLoopsForManyItems() throws Exception {
        makesFrames(NESTED);
    }

    @Test
    void sameRuleIsReportedInForksAndAfterARewind() throws Exception {
        try (Simulation simulation = simulation(NEAR)) {
            simulation.loop().run(2);
            try (SimulationImage image = simulation.keep();
                    Simulation fork = simulation.fork(image)) {
                fork.loop().run(2);
                simulation.loop().run(2);
                long hash = simulation.physics().stateHash();
                assertThat(fork.physics().stateHash()).isEqualTo(hash);
                assertThat(tooManySteps(fork)).hasSize(1);

                simulation.rewind(image);
                simulation.loop().run(2);

                assertThat(simulation.physics().stateHash()).isEqualTo(hash);
                assertThat(tooManySteps(simulation)).hasSize(2);
            }
        }
    }

    @Test
    void tenRulesOfTenStepsForAHundredThousandItemsAreWithinTheBudget() throws Exception {
        try (Simulation simulation = simulation(HONEST)) {
            simulation.loop().run(1);

            assertThat(simulation.events().faults()).isEmpty();
            assertThat(simulation.world().find("a99999").orElseThrow().semantic().get("r9"))
                    .contains(true);
        }
    }

    @Test
    void stopEndsTheEvaluationOfRules() throws Exception {
        try (Simulation simulation = simulation(NESTED)) {
            simulation.loop().stop();
            simulation.loop().run(1);

            assertThat(simulation.events().faults()).isEmpty();
        }
    }
}
