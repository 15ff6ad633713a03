// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.EnumSet;
import java.util.List;
import java.util.Set;

/**
 * A loaded law.
 *
 * @param libraryId id of its library within the engine; at least 1, never reused
 * @param library name of its library
 * @param stages force evaluations per step, if the law is an integrator; otherwise 0
 * @param claims invariants that the law guarantees
 * @param uses properties in the order in which the law declares them
 * @param parameters in the order in which the law declares them
 * @param calls number of calls since the law was loaded
 * @param nanoseconds wall-clock time of these calls [ns]; for reports only
 * @param resting whether it is not called, because a field that it reads was not bound in the last
 *     step
 */
public record PhysicsLaw(
        int libraryId,
        String library,
        String name,
        String version,
        String doc,
        Phase phase,
        int stages,
        Set<Claim> claims,
        List<PropertyUse> uses,
        List<LawParameter> parameters,
        long calls,
        long nanoseconds,
        boolean resting) {
    /** The invariants that a law may guarantee, in the order of the bits `VESPER_CLAIM_…`. */
    public enum Claim {
        /** Claim that the sum of the law's forces is zero. */
        MOMENTUM,
        /** Claim that the sum of the law's moments is zero. */
        ANGULAR_MOMENTUM,
        /** Claim that the law does not depend on the place of the origin. */
        TRANSLATION,
        /** Claim that the forces of the law rotate with the world if the world is rotated. */
        ROTATION,
        /** Claim that the work of the law's forces is the decrease of its potential energy. */
        ENERGY
    }

    /** Copies the collections. */
    public PhysicsLaw {
        claims = Set.copyOf(claims);
        uses = List.copyOf(uses);
        parameters = List.copyOf(parameters);
    }

    /** Returns the claims of a set of bits `VESPER_CLAIM_…`; unknown bits have no meaning. */
    public static Set<Claim> claims(int bits) {
        Set<Claim> claims = EnumSet.noneOf(Claim.class);
        for (Claim claim : Claim.values()) {
            if ((bits & 1 << claim.ordinal()) != 0) {
                claims.add(claim);
            }
        }
        return claims;
    }
}
