// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.List;

/**
 * One loaded law.
 *
 * @param libraryId the library it came with, within its engine; at least 1, never reused
 * @param library name of that library
 * @param stages integrators: force evaluations per step; else 0
 * @param uses properties in the order the law declares them
 * @param parameters in the order the law declares them
 * @param calls of the law since it was loaded
 * @param nanoseconds spent in these calls, wall clock; for people, never for the world
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
