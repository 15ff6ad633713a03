// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Timeout;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.EnumSource;

import reve.core.frame.TimeBudget;
import reve.core.frame.TimeBudget.Response;

import java.util.Map;
import java.util.Optional;

/** A law that takes twice its budget, so that a frame takes longer than a sixtieth of a second. */
@Tag("slow")
@Timeout(value = 1200, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class SlowLawNativeTest {
    private static final double STEP_MILLISECONDS = 6; // 24 ms in a frame of four steps
    private static final long BUDGET_NANOS = 12_000_000;
    private static final int PATIENCE = 10;
    private static final int INTERVAL = 4;

    /** Fraction of 60 frames/s that the fault model requires. */
    private static final double LEAST = 0.95;

    /** Number of seconds after which the world has recovered, on an idle machine: 2. */
    private static final int RECOVERY = Integer.getInteger("reve.test.recovery.seconds", 600);

    @ParameterizedTest
    @EnumSource(
            value = Response.class,
            names = {"UNLOAD", "SKIP_STEPS"})
    void theOtherLawsAreEvaluatedInTimeAgain(Response response) {
        try (HostedFixture hosted = new HostedFixture()) {
            AdapterFixture world = hosted.world.load("newton_motion");
            Ticks ticks = new Ticks();
            world.adapter.laws().load(0, "busy", Map.of("milliseconds", STEP_MILLISECONDS));
            assertThat(ticks.second(world)).as("the law slows the world").isLessThan(LEAST);
            world.adapter.enforceBudgets(true);
            world.adapter
                    .laws()
                    .setBudget(
                            "busy",
                            Optional.of(
                                    new TimeBudget(BUDGET_NANOS, PATIENCE, response, INTERVAL)));
            int seconds = 0;
            double rate;
            do {
                rate = ticks.second(world);
                seconds++;
            } while (rate < LEAST && seconds <= RECOVERY);
            assertThat(rate).as("frame rate after " + seconds + " s").isGreaterThanOrEqualTo(LEAST);
            assertThat(world.events("over-budget").getFirst().fields())
                    .containsEntry("library", "busy");
            assertThat(world.events("fault")).isEmpty();
        }
    }
}
