// SPDX-License-Identifier: Apache-2.0
package reve.pe;

import java.util.List;

/**
 * What one law, or somebody else, gave to the bodies since the ledger was opened, in SI units.
 *
 * @param name of the law; else "client", "ground", "unloaded" or "total"
 * @param law whether it is a law's
 * @param momentum x, y, z [kg*m/s]
 * @param angularMomentum x, y, z about the origin [kg*m^2/s]
 * @param energy kinetic [J]: the work of a force law
 * @param hasPotentialEnergy whether the law reports potential energy; else the next two are 0
 * @param initialPotentialEnergy when the ledger first saw the law's arrays [J]
 * @param potentialEnergy of the present state [J]
 */
public record LedgerLine(
        String name,
        boolean law,
        List<Double> momentum,
        List<Double> angularMomentum,
        double energy,
        boolean hasPotentialEnergy,
        double initialPotentialEnergy,
        double potentialEnergy) {
    /** Copies the lists. */
    public LedgerLine {
        momentum = List.copyOf(momentum);
        angularMomentum = List.copyOf(angularMomentum);
    }

    /** What potential energy rose by [J]. */
    public double potentialChange() {
        return potentialEnergy - initialPotentialEnergy;
    }

    /** Work and change of potential energy [J]: 0 for forces that keep energy. */
    public double energyBalance() {
        return energy + potentialChange();
    }
}
