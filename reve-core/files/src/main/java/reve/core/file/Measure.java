// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.rule.Expression;
import reve.core.unit.Unit;

import java.util.Optional;
import java.util.OptionalDouble;

/**
 * A value that an experiment measures in each of its runs.
 *
 * @param place position in the file, as {@code file:line:column}, for messages
 * @param take the way in which the measurements of a run become one value
 * @param expected the expected value of this run, if the file states one
 * @param tolerance maximum relative error of the value; empty if any error is accepted
 * @param unit the unit in which plots show the measured values; empty if it is not known
 */
public record Measure(
        String name,
        String place,
        Source source,
        Take take,
        OptionalDouble expected,
        OptionalDouble tolerance,
        Optional<Unit> unit) {
    private static final Unit SECOND = Unit.parse("s");

    /**
     * Returns the unit in which plots show the value of a run; empty if it is not known. It differs
     * from {@link #unit} if the value is a period.
     */
    public Optional<Unit> unitOfRuns() {
        return take == Take.PERIOD ? Optional.of(SECOND) : unit;
    }

    /** The origin of a value. */
    public sealed interface Source {}

    /** The value of an expression for one item. */
    public record OfItem(String item, Expression expression) implements Source {}

    /**
     * A value that is computed from all items of a kind.
     *
     * @param itemClass class of the items; empty for items of any class
     */
    public record OfKind(Fold fold, String kind, Optional<String> itemClass, Expression expression)
            implements Source {}

    /**
     * A value of the ledger, which contains the changes of energy and momentum by their causes.
     *
     * @param line name of a law, or client, ground, unloaded or total
     */
    public record OfLedger(String line, LedgerValue value) implements Source {}

    /** The energy of the world [J]. */
    public record Energy(EnergyPart part) implements Source {}

    /** The way in which the values of several items become one. */
    public enum Fold {
        /** The sum, added in the order of the items. */
        SUM,
        /** The sum, divided by the number of items. */
        MEAN,
        /** The smallest value. */
        MIN,
        /** The largest value. */
        MAX
    }

    /** A column of the ledger. */
    public enum LedgerValue {
        /** Change of momentum [kg*m/s]. */
        MOMENTUM("momentum", "kg*m/s"),
        /** Change of angular momentum about the origin [kg*m^2/s]. */
        ANGULAR_MOMENTUM("angularMomentum", "kg*m^2/s"),
        /** Change of kinetic energy [J]. */
        ENERGY("energy", "J"),
        /** Potential energy [J]. */
        POTENTIAL_ENERGY("potentialEnergy", "J"),
        /** Change of potential energy [J]. */
        POTENTIAL_CHANGE("potentialChange", "J"),
        /** Sum of the changes of kinetic and potential energy [J]. */
        ENERGY_BALANCE("energyBalance", "J");

        private final String key;
        private final Unit unit;

        LedgerValue(String key, String unit) {
            this.key = key;
            this.unit = Unit.parse(unit);
        }

        /** Returns the unit of the numbers. */
        public Unit unit() {
            return unit;
        }

        /** Returns the name in files and messages. */
        public String key() {
            return key;
        }
    }

    /** A part of the energy. */
    public enum EnergyPart {
        /** Kinetic energy of the translation and rotation of all bodies. */
        KINETIC,
        /** The sum of the laws' potential energies. */
        POTENTIAL,
        /** The sum of kinetic and potential energy. */
        TOTAL
    }

    /** The way in which the measurements of a run become one value. */
    public enum Take {
        /** The value at the end of the run. */
        END,
        /** The smallest value. */
        MIN,
        /** The largest value. */
        MAX,
        /** The arithmetic mean. */
        MEAN,
        /**
         * The mean time between two successive passages through 0 from below [s]. The time of each
         * passage is interpolated linearly between two measurements.
         */
        PERIOD
    }
}
