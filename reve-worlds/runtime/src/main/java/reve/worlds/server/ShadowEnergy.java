// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.world.Column;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;
import reve.pe.LedgerLine;
import reve.pe.PhysicsException;
import reve.pe.adapter.PhysicsAdapter;

import java.lang.foreign.MemorySegment;
import java.util.List;
import java.util.Locale;
import java.util.Optional;

/**
 * The energy that the laws of a copy add to its bodies. It consists of the kinetic energy and of
 * the potential energy that laws report. The gain is compared with the sum of three energies:
 *
 * <ul>
 *   <li>the largest kinetic energy of the world in the same frames;
 *   <li>the potential energy of the copy at the beginning;
 *   <li>the kinetic energy that all bodies would have at 1 m/s, so that the limit of a world at
 *       rest is not 0.
 * </ul>
 *
 * <p>For the copy's thread only.
 */
final class ShadowEnergy {
    static final String MASS = "mass";

    private final PhysicsAdapter physics;
    private final World world;
    private final double limit;
    private final boolean known;
    private Sums before = new Sums(0, 0, 0);
    private double gain;
    private double worlds;
    private double atStart = Double.NaN;

    /** Sums of the ledger [J]. */
    private record Sums(double kinetic, double potential, double client) {
        double ofLaws() {
            return kinetic + potential - client;
        }
    }

    /**
     * @param limit maximum gain, as a multiple of the energies that it is compared with
     */
    ShadowEnergy(World world, PhysicsAdapter physics, double limit) {
        this.world = world;
        this.physics = physics;
        this.limit = limit;
        known = opened(physics);
    }

    private static boolean opened(PhysicsAdapter physics) {
        try {
            physics.setLedger(true);
            return true;
        } catch (PhysicsException noBodies) {
            return false; // the prototype has no mass, position or velocity
        }
    }

    /**
     * Records the energy before the laws of a frame act. At this time, all changes that laws do not
     * make are done.
     */
    void before() {
        if (known) {
            before = sums(ledger());
            if (Double.isNaN(atStart)) {
                atStart = Math.abs(before.potential);
            }
        }
    }

    /**
     * Records the energy after the laws of a frame have acted.
     *
     * @param ledger the ledger at the end of the frame; empty if the energy is not known
     */
    void after(ShadowFrame frame, List<LedgerLine> ledger) {
        if (known) {
            gain += sums(ledger).ofLaws() - before.ofLaws();
            worlds = frame.hasRows() ? Math.max(worlds, kineticOfWorld(frame)) : worlds;
        }
    }

    /** Returns the gain so far [J]; empty if the energy is not known. */
    Optional<Double> gain() {
        return known ? Optional.of(gain) : Optional.empty();
    }

    /** Returns the gain at which a version is refused [J]. */
    double mostGain() {
        return limit * (worlds + atStart + kinetic(null));
    }

    /** Returns why the version is refused; empty if it is not. */
    Optional<String> excess() {
        double most = mostGain();
        return known && gain > most
                ? Optional.of(
                        String.format(
                                Locale.ROOT,
                                "it gave the bodies %.3g J, more than the limit of %.3g J, which is"
                                        + " %.3g times the energy of the bodies",
                                gain,
                                most,
                                limit))
                : Optional.empty();
    }

    /** Returns the copy's ledger; empty if the prototype has no bodies. */
    List<LedgerLine> ledger() {
        return known ? physics.ledger() : List.of();
    }

    private static Sums sums(List<LedgerLine> lines) {
        double potential = 0;
        double kinetic = 0;
        double client = 0;
        for (LedgerLine line : lines) {
            if (line.law()) {
                potential += line.potentialEnergy();
            } else if (line.name().equals("total")) {
                kinetic = line.energy();
            } else if (line.name().equals("client")) {
                client = line.energy();
            }
        }
        return new Sums(kinetic, potential, client);
    }

    private double kineticOfWorld(ShadowFrame frame) {
        return kinetic(MemorySegment.ofArray(frame.velocities()));
    }

    /**
     * Returns the kinetic energy of translation of all bodies [J].
     *
     * @param velocities velocities of the bodies; if null, each body has 1 m/s
     */
    private double kinetic(@Nullable MemorySegment velocities) {
        Table bodies = world.table(WorldPrototype.BODY);
        Column mass = bodies.column(MASS);
        Column velocity = bodies.column(ShadowFrame.VELOCITY);
        MemorySegment masses = ShadowFrame.rows(world, MASS);
        double metres = velocity.unit().scale();
        double sum = 0;
        for (int row = 0; row < bodies.physicsRowCount(); row++) {
            double squares = velocities == null ? 1 : 0;
            if (velocities != null) {
                for (int i = 0; i < velocity.components(); i++) {
                    double v =
                            ShadowDivergence.number(
                                            velocities, velocity, row * velocity.components() + i)
                                    * metres;
                    squares += v * v;
                }
            }
            sum += ShadowDivergence.number(masses, mass, row) * squares;
        }
        return sum * mass.unit().scale() / 2;
    }
}
