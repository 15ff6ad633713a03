// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.List;

/**
 * A loaded law.
 *
 * @param libraryId its library within the engine; at least 1, never reused
 * @param library name of that library
 * @param stages force evaluations per step, if the law is an integrator; otherwise 0
 * @param uses properties in the order in which the law declares them
 * @param parameters in the order in which the law declares them
 * @param calls number of calls since the law was loaded
 * @param nanoseconds wall-clock time of these calls [ns]; for reports only
 */
public record PhysicsLaw(
        int libraryId,
        String library,
        String name,
        String version,
        String doc,
        Phase phase,
        int stages,
        List<PropertyUse> uses,
        List<LawParameter> parameters,
        long calls,
        long nanoseconds) {
    /** Copies the lists. */
    public PhysicsLaw {
        uses = List.copyOf(uses);
        parameters = List.copyOf(parameters);
    }
}
