// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.io.ByteArrayOutputStream;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;
import java.util.concurrent.atomic.AtomicLong;

/** The progress line of experiments. */
class ExperimentProgressTest {
    @Test
    void theTimeThatIsLeftFollowsFromTheRunsThatAreDone() {
        var out = new ByteArrayOutputStream();
        var now = new AtomicLong();
        var progress =
                new ExperimentProgress(
                        new PrintStream(out, true, StandardCharsets.UTF_8), false, 4, now::get);
        now.set(1_000_000_000L);
        progress.advanced(0.5);
        assertThat(out.toString(StandardCharsets.UTF_8)).isEmpty();
        now.set(30_000_000_000L);
        progress.advanced(0.5);
        assertThat(out.toString(StandardCharsets.UTF_8))
                .isEqualToIgnoringNewLines("0 of 4 runs, 25 %, about 1 min 30 s left");
    }

    @Test
    void runsOfAnEarlierProcessDoNotShortenTheTimeThatIsLeft() {
        var out = new ByteArrayOutputStream();
        var now = new AtomicLong();
        var progress =
                new ExperimentProgress(
                        new PrintStream(out, true, StandardCharsets.UTF_8), false, 8, now::get);
        progress.resumed(6);
        now.set(30_000_000_000L);
        progress.advanced(0.5);
        assertThat(out.toString(StandardCharsets.UTF_8))
                .isEqualToIgnoringNewLines("6 of 8 runs, 81 %, about 1 min 30 s left");
    }

    @Test
    void durationsHaveTwoUnits() {
        assertThat(Progress.duration(7.6)).isEqualTo("8 s");
        assertThat(Progress.duration(125)).isEqualTo("2 min 5 s");
        assertThat(Progress.duration(7500)).isEqualTo("2 h 5 min");
    }
}
