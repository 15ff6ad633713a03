// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.agent.protocol.MessageWriter;

import java.util.List;

/**
 * The numbers that an instrument of a body measured in one frame. Immutable.
 *
 * @param sensor name of the instrument
 * @param frame the frame of the measurement
 * @param quantities the measured numbers, at least one
 * @param columns number of rays in a row of a lidar; 0 for other instruments
 */
public record Reading(String sensor, long frame, List<Quantity> quantities, int columns) {

    /** Creates the reading of an instrument other than a lidar. */
    Reading(String sensor, long frame, List<Quantity> quantities) {
        this(sensor, frame, quantities, 0);
    }

    /**
     * A measured quantity.
     *
     * @param numbers must not change
     */
    record Quantity(String name, double[] numbers) {}

    /** Returns whether a view contains readings that were made after a frame. */
    static boolean isAnyNewerThan(long frame, View view) {
        List<Reading> readings = view.readings();
        for (int i = 0; i < readings.size(); i++) { // a loop with an iterator would allocate memory
            if (readings.get(i).frame > frame) {
                return true;
            }
        }
        return false;
    }

    /** Writes the field {@code readings} with those readings that were made after a frame. */
    static void write(MessageWriter writer, View view, long frame) {
        if (!isAnyNewerThan(frame, view)) {
            return;
        }
        List<Reading> newer =
                view.readings().stream().filter(reading -> reading.frame > frame).toList();
        writer.key("readings");
        writer.beginMap(newer.size());
        for (Reading reading : newer) {
            writer.key(reading.sensor);
            reading.write(writer);
        }
        writer.endMap();
    }

    private void write(MessageWriter writer) {
        writer.beginMap((columns > 0 ? 2 : 1) + quantities.size());
        writer.key("frame");
        writer.integer(frame);
        if (columns > 0) {
            writer.key("columns");
            writer.integer(columns);
        }
        for (Quantity quantity : quantities) {
            writer.key(quantity.name);
            writer.numbers(quantity.numbers, 0, quantity.numbers.length);
        }
        writer.endMap();
    }
}
