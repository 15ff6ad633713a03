// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.List;

/**
 * The contribution of one law, or of another source, to the motion of the bodies since the ledger
 * was opened. Values are in SI units.
 *
 * @param name name of the law; for other sources "client", "ground", "unloaded" or "total"
 * @param law true if the source is a loaded law
 * @param momentum x, y, z [kg*m/s]
 * @param angularMomentum x, y, z about the origin [kg*m^2/s]
 * @param energy change of kinetic energy [J]: the work of a force law
 * @param hasPotentialEnergy whether the law reports potential energy; otherwise the next two
 *     numbers are 0
 * @param initialPotentialEnergy potential energy when the ledger first recorded this law [J]
 * @param potentialEnergy potential energy of the present state [J]
 * @param impulseSize sum of the magnitudes of the impulses that the law's forces gave to each body
 *     in each step [kg*m/s]; 0 for other sources
 * @param angularImpulseSize sum of the magnitudes of the angular impulses about the origin that the
 *     law's forces and torques gave to each body in each stage of a step [kg*m^2/s]
 */
public record LedgerLine(
        String name,
        boolean law,
        List<Double> momentum,
        List<Double> angularMomentum,
        double energy,
        boolean hasPotentialEnergy,
        double initialPotentialEnergy,
        double potentialEnergy,
        double impulseSize,
        double angularImpulseSize) {
    /** Copies the lists. */
    public LedgerLine {
        momentum = List.copyOf(momentum);
        angularMomentum = List.copyOf(angularMomentum);
    }

    /** Returns the increase of potential energy [J]. */
    public double potentialChange() {
        return potentialEnergy - initialPotentialEnergy;
    }

    /** Returns the sum of work and change of potential energy [J]; 0 for conservative forces. */
    public double energyBalance() {
        return energy + potentialChange();
    }
}
