// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.file.Measure.Take;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.function.DoubleUnaryOperator;

/** The values that summarize the measurements of a run. */
class SummaryTest {
    private static List<Sample> samples(int count, double dt, DoubleUnaryOperator value) {
        List<Sample> samples = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            samples.add(new Sample(i, i * dt, List.of(Optional.of(value.applyAsDouble(i * dt)))));
        }
        return samples;
    }

    @Test
    void thePeriodOfAnOscillationIsTheTimeBetweenItsPassages() {
        double period = 0.731;
        List<Sample> samples =
                samples(300, 1.0 / 60, t -> 3 * Math.cos(2 * Math.PI * t / period + 0.4));

        double measured = (Double) Summary.of(Take.PERIOD, samples, 0).orElseThrow();

        assertThat(measured).isCloseTo(period, within(1e-3 * period));
    }

    @Test
    void aValueThatPassesThroughZeroOnceHasNoPeriod() {
        assertThat(Summary.of(Take.PERIOD, samples(9, 1, t -> t - 4), 0)).isEmpty();
    }

    @Test
    void leastGreatestAndMeanOmitMissingValuesAndTheEndDoesNot() {
        List<Sample> samples = new ArrayList<>(samples(3, 1, t -> 4 * t - 1));
        samples.add(new Sample(3, 3, List.of(Optional.empty())));
        assertThat(Summary.of(Take.MIN, samples, 0)).contains(-1.0);
        assertThat(Summary.of(Take.MAX, samples, 0)).contains(7.0);
        assertThat(Summary.of(Take.MEAN, samples, 0)).contains(3.0);
        assertThat(Summary.of(Take.END, samples, 0)).isEmpty();
    }

    @Test
    void aTableIsReadBackToTheBit() {
        List<List<String>> rows =
                List.of(
                        List.of("run", "a, \"b\"", "c"),
                        List.of("1", ResultTable.text(0.1 + 0.2), "two\nlines"),
                        List.of("2", ResultTable.text(List.of(1.0, -0.0, 1e300)), ""));
        var text = new StringBuilder();
        rows.forEach(row -> text.append(ResultTable.line(row)).append('\n'));

        assertThat(ResultTable.parse(text.toString())).contains(rows);
        assertThat(rows.get(1).get(1)).isEqualTo("0.30000000000000004");
        assertThat(rows.get(2).get(1)).isEqualTo("1 -0.0 1.0E300");
        assertThat(ResultTable.parse("a,\"b")).isEmpty();
    }
}
