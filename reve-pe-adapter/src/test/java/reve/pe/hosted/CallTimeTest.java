// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.pe.posix.ProcessGroup;

class CallTimeTest {
    private static final long MS = 1_000_000;
    private static final long LIMIT = 3000 * MS;
    private static final long START = 7 * MS;

    private final CallTime time = new CallTime(LIMIT, START);

    /** Milliseconds in one state after which a host with a limit of 3 s is ended. */
    @ParameterizedTest
    @CsvSource({"SLEEPS, 3000", "STOPPED, 3000", "WAITS_FOR_DISK, 3500", "OTHER, 60000"})
    void aHostThatUsesNoProcessorIsEnded(ProcessGroup.State state, int most) {
        int elapsed = 0;
        while (!time.isLate(false)) {
            assertThat(time.counts(MS, START)).isFalse();
            time.countsWithoutProcessor(MS, state);
            elapsed++;
        }
        assertThat(elapsed).isEqualTo(most);
    }

    @Test
    void processorTimeCountsAndDoesNotShrinkWhenTheHostHasEnded() {
        assertThat(time.counts(10 * MS, START + LIMIT - MS)).isTrue();
        assertThat(time.isLate(false)).isFalse();
        assertThat(time.counts(MS, -1)).isFalse();
        assertThat(time.spentNanos()).isEqualTo(LIMIT - MS);
        assertThat(time.counts(MS, START + LIMIT)).isTrue();
        assertThat(time.isLate(false)).isTrue();
        assertThat(time.isLate(true)).as("a law that runs apart is ended by its host").isFalse();
    }
}
