// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.unit.Unit;

import java.util.List;

/**
 * The declaration of a measurement in Java: its name and its quantities. A {@link SensorProvider}
 * is a gauge that also measures.
 */
public interface Gauge {
    /** Maximum number of numbers in the quantities of one sensor. */
    int MAX_NUMBERS = 4096;

    /**
     * Returns the name by which sensors refer to the gauge, for example {@code example.compass}.
     */
    String name();

    /** Returns one sentence that describes the measurement. */
    String doc();

    /**
     * Returns the measured quantities, at least one. Their names are unique. They have at most
     * {@link #MAX_NUMBERS} components in all. The gauge must always return the same quantities.
     */
    List<Quantity> quantities();

    /**
     * A quantity that a sensor measures.
     *
     * @param name name of the quantity in readings, for example {@code heading}
     * @param components number of components, at least 1
     * @param unit unit of the measured numbers, for documentation
     */
    record Quantity(String name, int components, Unit unit) {
        /**
         * Checks name and number.
         *
         * @throws IllegalArgumentException if the name is not a name, is a field of every reading,
         *     or the number of components is less than 1
         */
        public Quantity {
            Names.require("quantity", name);
            if (name.equals("frame") || name.equals("columns")) {
                throw new IllegalArgumentException(
                        "quantity " + name + ": each reading has a field of this name");
            }
            if (components < 1) {
                throw new IllegalArgumentException(
                        "quantity " + name + ": " + components + " components, expected 1 or more");
            }
        }
    }

    /**
     * Returns the number of components of all quantities.
     *
     * @throws IllegalArgumentException naming the gauge if its quantities are impossible
     */
    static int numbers(Gauge gauge) {
        List<Quantity> quantities = gauge.quantities();
        long numbers = quantities.stream().mapToLong(Quantity::components).sum();
        long names = quantities.stream().map(Quantity::name).distinct().count();
        if (quantities.isEmpty() || names < quantities.size() || numbers > MAX_NUMBERS) {
            throw new IllegalArgumentException(
                    "sensor "
                            + gauge.name()
                            + " measures "
                            + quantities.stream().map(Quantity::name).toList()
                            + " with "
                            + numbers
                            + " numbers, expected one or more different quantities with at most "
                            + MAX_NUMBERS
                            + " numbers in all");
        }
        return (int) numbers;
    }
}
