// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.file.RunPoint;

import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;

/**
 * The result of a run.
 *
 * @param message the reason why the run failed, or the value that is outside of its tolerance;
 *     empty if there is neither
 * @param frames number of frames made
 * @param stateHash hash of the state at the end, in hexadecimal; empty if the run failed
 * @param samples measurements, in the order of frames
 * @param values the value of each measure for the table of runs; empty if it has none
 * @param expected the expected value of each measure, if it has one
 * @param notes measures without a value, with the reason
 * @param laws SHA-256 of the law libraries at the end, by name
 */
public record RunResult(
        RunPoint point,
        State state,
        String message,
        long frames,
        String stateHash,
        List<Sample> samples,
        List<Optional<Object>> values,
        List<Optional<Double>> expected,
        List<String> notes,
        Map<String, String> laws) {
    /** The outcome of a run. */
    public enum State {
        /** State of a complete run. */
        OK,
        /** State of a complete run in which a value is outside of its tolerance. */
        OUTSIDE,
        /** State of a run that ended early, or in which a law failed. */
        FAILED
    }

    /** Copies the lists and sorts the map. */
    public RunResult {
        samples = List.copyOf(samples);
        values = List.copyOf(values);
        expected = List.copyOf(expected);
        notes = List.copyOf(notes);
        laws = new TreeMap<>(laws);
    }

    /** Returns the result of a run that could not begin. */
    static RunResult failed(RunPoint point, String message, int measures) {
        List<Optional<Object>> none = Collections.nCopies(measures, Optional.<Object>empty());
        return new RunResult(
                point,
                State.FAILED,
                message,
                0,
                "",
                List.of(),
                none,
                Collections.nCopies(measures, Optional.<Double>empty()),
                List.of(),
                Map.of());
    }

    /**
     * Returns the relative error of a value, (value - expected) / |expected|. Returns the absolute
     * error if the expected value is 0.
     */
    static double relativeError(double value, double expected) {
        return expected == 0 ? value : (value - expected) / Math.abs(expected);
    }

    /** Returns the error of a measure. Empty if the measure has no value or no expected value. */
    public Optional<Double> error(int measure) {
        return expected.get(measure)
                .flatMap(
                        right ->
                                values.get(measure)
                                        .filter(Double.class::isInstance)
                                        .map(value -> relativeError((Double) value, right)));
    }
}
