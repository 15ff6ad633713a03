// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.util.concurrent.TimeUnit;

class ReadBudgetTest {
    private static final long SECOND = TimeUnit.SECONDS.toNanos(1);

    private long now;
    private int connections = 1;
    private final ReadBudget budget = new ReadBudget(() -> connections, () -> now);

    @Test
    void aBurstIsReadAtOnceAndTheRestLater() {
        budget.spend(ReadBudget.BURST);
        assertThat(budget.waitNanos()).isZero();
        budget.spend(131_072); // a 32nd of what all connections may send in a second
        assertThat(budget.waitNanos()).isEqualTo(SECOND);
        now += SECOND;
        assertThat(budget.waitNanos()).isZero();
    }

    @Test
    void silenceSavesNoMoreThanABurst() {
        now += 100 * SECOND;
        budget.spend(ReadBudget.BURST + 131_072);
        assertThat(budget.waitNanos()).isEqualTo(SECOND);
    }

    @Test
    void manyConnectionsShareWhatOneAlonePartlyLeaves() {
        connections = 320;
        budget.spend(ReadBudget.BURST + 131_072);
        assertThat(budget.waitNanos()).isEqualTo(10 * SECOND);
    }

    @Test
    void aPageOfManyFilesAndALongLawDoesNotWait() {
        budget.spend(30 * ReadBudget.REQUEST_BYTES);
        assertThat(budget.waitNanos()).isZero();
        now += SECOND;
        budget.spend(60_000);
        assertThat(budget.waitNanos()).isZero();
    }
}
