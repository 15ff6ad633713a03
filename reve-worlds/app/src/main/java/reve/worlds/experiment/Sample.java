// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import java.util.List;
import java.util.Optional;

/**
 * The values of all measures at the end of a frame.
 *
 * @param timeSeconds world time since the beginning of the run [s]
 * @param values a Double, Boolean, String or List for each measure; empty if it has no value
 */
public record Sample(long frame, double timeSeconds, List<Optional<Object>> values) {
    /** Copies the list. */
    public Sample {
        values = List.copyOf(values);
    }
}
