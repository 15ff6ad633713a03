// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.world.ActionRefused;

import java.util.concurrent.atomic.AtomicLong;

/** The pace of the commands that change many items. Time passes only while a command waits. */
class ItemPaceTest {
    private final AtomicLong nanos = new AtomicLong(7);
    private boolean shared = true;
    private final ItemPace pace = new ItemPace(() -> shared, nanos::get, nanos::addAndGet);

    private double seconds() {
        return (nanos.get() - 7) * 1e-9;
    }

    @Test
    void commandsWithFewItemsDoNotWait() throws ActionRefused {
        for (int i = 0; i < 1000; i++) {
            pace.take(20);
        }
        assertThat(seconds()).isZero();
    }

    /** Otherwise the rewind of a large world would delay the next command by minutes. */
    @Test
    void oneCommandWithManyItemsDelaysTheNextOnesByTwoSeconds() throws ActionRefused {
        pace.take(15_000);
        pace.take(1_000_000);
        assertThat(seconds()).isZero();
        pace.take(1);
        assertThat(seconds()).as("15,000 items too many").isCloseTo(1.5, within(1e-6));
    }

    @Test
    void commandsWithoutEndHaveThePace() throws ActionRefused {
        for (int i = 0; i < 100; i++) {
            pace.take(9_600);
        }
        double items = 100 * 9_600 - ItemPace.AHEAD - 9_600;
        assertThat(seconds()).isCloseTo(items / ItemPace.PER_SECOND, within(1e-3));
        nanos.addAndGet(60_000_000_000L);
        double before = seconds();
        pace.take((int) ItemPace.AHEAD);
        pace.take(1);
        assertThat(seconds()).as("after a rest").isEqualTo(before);
    }

    @Test
    void aCommandThatWouldWaitForLongIsRefusedAndCostsNothing() throws ActionRefused {
        var still = new ItemPace(() -> true, nanos::get, _ -> {}); // other clients, which wait
        for (int i = 0; i < 4; i++) {
            still.take(20_000);
        }
        for (int i = 0; i < 3; i++) {
            assertThatExceptionOfType(ActionRefused.class)
                    .isThrownBy(() -> still.take(5_000))
                    .withMessageContaining("more than 80000 items")
                    .withMessageContaining("try again in 6 s")
                    .satisfies(refused -> assertThat(refused.code()).isEqualTo("world-busy"));
        }
        nanos.addAndGet(6_000_000_000L);
        still.take(1);
    }

    @Test
    void theOnlyWorldOfAServerHasNoPace() throws ActionRefused {
        shared = false;
        for (int i = 0; i < 100; i++) {
            pace.take(9_600);
        }
        assertThat(seconds()).isZero();
    }
}
