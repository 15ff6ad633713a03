// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.Measure;

import java.util.List;
import java.util.Optional;

/** The value of a measure for the table of runs. It is computed from the measurements of a run. */
final class Summary {
    private Summary() {}

    /**
     * Returns the value for the table; empty if there are too few measurements to compute it.
     *
     * @param index the index of the measure in each sample
     */
    static Optional<Object> of(Measure.Take take, List<Sample> samples, int index) {
        if (take == Measure.Take.END) {
            return samples.isEmpty() ? Optional.empty() : samples.getLast().values().get(index);
        }
        double sum = 0;
        double least = Double.POSITIVE_INFINITY;
        double greatest = Double.NEGATIVE_INFINITY;
        int count = 0;
        for (Sample sample : samples) {
            if (sample.values().get(index).orElse(null) instanceof Double value) {
                sum += value;
                least = Math.min(least, value);
                greatest = Math.max(greatest, value);
                count++;
            }
        }
        if (count == 0) {
            return Optional.empty();
        }
        return switch (take) {
            case END, MEAN -> Optional.of(sum / count);
            case MIN -> Optional.of(least);
            case MAX -> Optional.of(greatest);
            case PERIOD -> period(samples, index).map(value -> value);
        };
    }

    /** Returns the mean time between upward passages of the value through 0 [s]. */
    private static Optional<Double> period(List<Sample> samples, int index) {
        double first = Double.NaN;
        double last = Double.NaN;
        int passages = 0;
        for (int i = 1; i < samples.size(); i++) {
            if (samples.get(i - 1).values().get(index).orElse(null) instanceof Double before
                    && samples.get(i).values().get(index).orElse(null) instanceof Double after
                    && before < 0
                    && after >= 0) {
                double from = samples.get(i - 1).timeSeconds();
                double to = samples.get(i).timeSeconds();
                last = from + (to - from) * (-before / (after - before));
                if (passages++ == 0) {
                    first = last;
                }
            }
        }
        return passages < 2 ? Optional.empty() : Optional.of((last - first) / (passages - 1));
    }
}
