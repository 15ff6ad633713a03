// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.world.Column;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.pe.LedgerLine;
import reve.pe.Phase;
import reve.pe.PhysicsLaw;
import reve.pe.PhysicsLaw.Claim;

import java.lang.foreign.MemorySegment;
import java.util.List;
import java.util.Locale;
import java.util.Optional;
import java.util.Set;

/**
 * The check of the conservation that new versions claim, by the ledger of a copy. The forces of a
 * law that claims momentum must sum to zero. The moments of a law that claims angular momentum must
 * sum to zero. The limits allow for rounding in {@code f32}. For the copy's thread only.
 */
final class ShadowClaims {
    /**
     * Maximum sum as a fraction of a reference value. The reference value is the sum of the
     * magnitudes of the impulses, plus the momentum that all bodies would have at 1 m/s. The
     * momentum is included because forces may cancel each other at each body.
     */
    private static final double LIMIT = 1e-3;

    private final World world;
    private final Set<Integer> libraries;

    /**
     * @param libraries ids of the libraries of new versions in the copy
     */
    ShadowClaims(World world, Set<Integer> libraries) {
        this.world = world;
        this.libraries = Set.copyOf(libraries);
    }

    /**
     * Returns a message about a claim that a new version breaks; empty if it breaks none.
     *
     * @param laws the laws of the copy's engine, in load order
     * @param ledger the ledger of the copy; it begins with the lines of these laws, or is empty if
     *     there are no bodies
     */
    Optional<String> broken(List<PhysicsLaw> laws, List<LedgerLine> ledger) {
        if (ledger.isEmpty()) {
            return Optional.empty();
        }
        for (int i = 0; i < laws.size(); i++) {
            PhysicsLaw law = laws.get(i);
            LedgerLine line = ledger.get(i);
            // Only laws of the phase FORCE exert forces. The ledger lines of other laws contain the
            // momentum that bodies exchange with the ground.
            if (!libraries.contains(law.libraryId()) || law.phase() != Phase.FORCE) {
                continue;
            }
            if (law.claims().contains(Claim.MOMENTUM)) {
                double limit = LIMIT * (line.impulseSize() + atOneMetrePerSecond(false));
                Optional<String> broken =
                        broken(law, "momentum", "forces", line.momentum(), limit, "kg*m/s");
                if (broken.isPresent()) {
                    return broken;
                }
            }
            if (law.claims().contains(Claim.ANGULAR_MOMENTUM)) {
                double limit = LIMIT * (line.angularImpulseSize() + atOneMetrePerSecond(true));
                Optional<String> broken =
                        broken(
                                law,
                                "angular momentum",
                                "moments about the origin",
                                line.angularMomentum(),
                                limit,
                                "kg*m^2/s");
                if (broken.isPresent()) {
                    return broken;
                }
            }
        }
        return Optional.empty();
    }

    private static Optional<String> broken(
            PhysicsLaw law,
            String claim,
            String pushes,
            List<Double> sum,
            double limit,
            String unit) {
        double size = Math.sqrt(sum.stream().mapToDouble(component -> component * component).sum());
        return size > limit
                ? Optional.of(
                        String.format(
                                Locale.ROOT,
                                "law %s claims to conserve %s, but its %s gave the bodies %.3g %s,"
                                        + " more than the limit of %.3g %s; correct the law, or"
                                        + " remove the claim",
                                law.name(),
                                claim,
                                pushes,
                                size,
                                unit,
                                limit,
                                unit))
                : Optional.empty();
    }

    /**
     * Returns the sum of the magnitudes of the momenta that all bodies would have at 1 m/s
     * [kg*m/s].
     *
     * @param angular true to sum angular momenta about the origin instead, for velocities at right
     *     angles to the position [kg*m^2/s]
     */
    private double atOneMetrePerSecond(boolean angular) {
        Table bodies = world.table(WorldPrototype.BODY);
        Column mass = bodies.column(ShadowEnergy.MASS);
        Column position = bodies.column(ShadowFrame.POSITION);
        MemorySegment masses = ShadowFrame.rows(world, ShadowEnergy.MASS);
        MemorySegment positions = ShadowFrame.rows(world, ShadowFrame.POSITION);
        double metres = position.unit().scale();
        double sum = 0;
        for (int row = 0; row < bodies.physicsRowCount(); row++) {
            double arm = 1;
            if (angular) {
                double squares = 0;
                for (int i = 0; i < position.components(); i++) {
                    double x =
                            ShadowDivergence.number(
                                            positions, position, row * position.components() + i)
                                    * metres;
                    squares += x * x;
                }
                arm = Math.sqrt(squares);
            }
            sum += ShadowDivergence.number(masses, mass, row) * arm;
        }
        return sum * mass.unit().scale();
    }
}
