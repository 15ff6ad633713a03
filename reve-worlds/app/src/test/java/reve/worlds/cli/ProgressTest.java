// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.io.ByteArrayOutputStream;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;

/** The progress line of a long command, with a clock that the test sets. */
class ProgressTest {
    private final ByteArrayOutputStream bytes = new ByteArrayOutputStream();
    private final PrintStream out = new PrintStream(bytes, true, StandardCharsets.UTF_8);
    private long seconds;

    private Progress progress(boolean terminal, long total) {
        return new Progress(out, terminal, total, () -> seconds * 1_000_000_000L);
    }

    private String printed() {
        return bytes.toString(StandardCharsets.UTF_8);
    }

    @Test
    void aLineAppearsAfterTwoSecondsAndNamesTheTimeThatIsLeft() {
        Progress progress = progress(false, 600);
        seconds = 1;
        progress.at(60, 1);
        assertThat(printed()).isEmpty();
        seconds = 2;
        progress.at(150, 2.5);
        assertThat(printed())
                .isEqualTo(
                        "frame 150 of 600 (25 %), 2.50 s of world time, 1.25 x real time, about 6 s"
                                + " left\n");
        seconds = 3;
        progress.at(200, 3);
        assertThat(printed().lines()).hasSize(1);
        progress.done();
        assertThat(printed().lines()).hasSize(1);
    }

    @Test
    void aRunWithoutAnEndAndTheFirstStepsNameNoTime() {
        seconds = 2;
        Progress endless = progress(false, 0);
        seconds = 4;
        endless.at(120, 2);
        assertThat(printed()).isEqualTo("frame 120, 2.00 s of world time, 1.00 x real time\n");
        Progress early = progress(false, 0);
        seconds = 6;
        early.at("frame 1", 0.01);
        assertThat(printed()).endsWith("frame 1, 1 %\n");
    }

    @Test
    void aShorterLineOnATerminalCoversTheLongerOne() {
        Progress progress = progress(true, 0);
        seconds = 100;
        progress.at("drawing", 0.5);
        seconds = 102;
        progress.at("drawing", 0.999);
        progress.done();
        assertThat(printed())
                .isEqualTo(
                        "\rdrawing, 50 %, about 1 min 40 s left\rdrawing, 99 %, about 0 s left       "
                                + System.lineSeparator());
    }
}
