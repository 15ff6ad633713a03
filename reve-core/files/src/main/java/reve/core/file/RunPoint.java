// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * The values by which a run of an experiment differs from the other runs.
 *
 * @param number number of the run, from 1
 * @param itsCase name of the case, if the experiment has cases
 * @param values values of the swept variables [SI units], in the order of the file
 * @param seed seed of the run's random numbers
 */
public record RunPoint(
        int number, Optional<String> itsCase, Map<String, Double> values, long seed) {
    /** Copies the map, in its order. */
    public RunPoint {
        values = Collections.unmodifiableMap(new LinkedHashMap<>(values));
    }
}
