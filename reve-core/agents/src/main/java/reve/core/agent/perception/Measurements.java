// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.ColumnView;
import reve.core.world.Gauge;
import reve.core.world.Instrument;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.TableView;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The measurements of instruments in one frame. Contains copies of the columns into which the world
 * writes measurements. Columns that no instrument of an item needs are not copied. For one thread.
 */
final class Measurements {

    private final SensedWorld bodies;

    /** Copies of columns by name, (rows x components). */
    private final Map<String, double[]> columns = new LinkedHashMap<>();

    Measurements(SensedWorld bodies) {
        this.bodies = bodies;
    }

    /** Includes the columns that these sensors need in the copies from now on. */
    void expect(List<Sensor> sensors) {
        for (int i = 0; i < sensors.size(); i++) {
            sensors.get(i).instrument().ifPresent(this::expect);
        }
    }

    private void expect(Instrument instrument) {
        for (String property : WorldPrototype.measuredBy(instrument)) {
            columns.putIfAbsent(property, new double[0]);
        }
    }

    /** Copies the columns of a frame. */
    void read(TableView bodies) {
        if (columns.isEmpty()) {
            return;
        }
        for (Map.Entry<String, double[]> entry : columns.entrySet()) {
            ColumnView column = bodies.column(entry.getKey());
            int numbers = column.components() * bodies.rowCount();
            if (entry.getValue().length < numbers) {
                entry.setValue(new double[numbers + numbers / 2]);
            }
            SensedWorld.read(column, entry.getValue(), 0, numbers);
        }
    }

    /**
     * Returns the reading of a sensor, which has an instrument.
     *
     * @param time simulated time of the world [s]
     */
    Reading measure(Sensor sensor, ItemId body, int row, long frame, double time) {
        return switch (sensor.instrument().orElseThrow()) {
            case Instrument.Imu imu -> {
                var noise = new MeasurementNoise(imu.seed(), body, sensor.name(), time);
                yield new Reading(
                        sensor.name(),
                        frame,
                        List.of(
                                quantity(
                                        "specificForce",
                                        WorldPrototype.SPECIFIC_FORCE,
                                        row,
                                        imu.specificForce(),
                                        noise),
                                quantity(
                                        "angularVelocity",
                                        WorldPrototype.ANGULAR_RATE,
                                        row,
                                        imu.angularVelocity(),
                                        noise)));
            }
            case Instrument.ContactForce contact -> {
                double[] force = new double[3];
                for (int axis = 0; axis < 3; axis++) {
                    force[axis] =
                            number(WorldPrototype.CONTACT_FORCE, row, axis)
                                    + number(WorldPrototype.REACTION_FORCE, row, axis);
                }
                if (contact.ownAxes()) {
                    bodies.turnBack(row, force);
                }
                yield new Reading(
                        sensor.name(), frame, List.of(new Reading.Quantity("force", force)));
            }
            case Instrument.Provided _ ->
                    throw new IllegalStateException("the world measures it, see provided");
            case Instrument.Lidar _ ->
                    throw new IllegalStateException("a lidar takes time, see LidarScanner");
        };
    }

    /**
     * Returns the reading of a sensor with a provider.
     *
     * @param numbers components of all quantities
     */
    static Reading provided(
            Sensor sensor, Instrument.Provided provided, long frame, double[] numbers) {
        List<Reading.Quantity> quantities = new ArrayList<>();
        int at = 0;
        for (Gauge.Quantity quantity : provided.quantities()) {
            int end = at + quantity.components();
            quantities.add(
                    new Reading.Quantity(quantity.name(), Arrays.copyOfRange(numbers, at, end)));
            at = end;
        }
        return new Reading(sensor.name(), frame, quantities);
    }

    private double number(String property, int row, int axis) {
        double[] column = columns.get(property);
        return column == null ? 0 : column[3 * row + axis];
    }

    private Reading.Quantity quantity(
            String name,
            String property,
            int row,
            Instrument.Errors errors,
            MeasurementNoise noise) {
        double[] measured = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            measured[axis] =
                    number(property, row, axis) + errors.bias(axis) + noise.next(errors.noise());
        }
        return new Reading.Quantity(name, measured);
    }
}
