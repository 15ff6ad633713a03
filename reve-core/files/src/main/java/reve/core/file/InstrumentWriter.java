// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.Instrument;
import reve.core.world.Instrument.Errors;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/** Writer of the keys of a sensor that measures numbers. Omits default values. */
final class InstrumentWriter {

    private InstrumentWriter() {}

    /** Adds the key of an instrument to the tree of its sensor. */
    static void write(Instrument instrument, Map<String, Object> sensor) {
        Map<String, Object> tree = new LinkedHashMap<>();
        switch (instrument) {
            case Instrument.Imu imu -> {
                putErrors(tree, "specificForce", imu.specificForce());
                putErrors(tree, "angularVelocity", imu.angularVelocity());
                putSeed(tree, imu.seed());
                sensor.put(InstrumentReader.IMU, tree);
            }
            case Instrument.ContactForce contact -> {
                if (contact.ownAxes()) {
                    tree.put("axes", InstrumentReader.OWN_AXES);
                }
                sensor.put(InstrumentReader.CONTACT_FORCE, tree);
            }
            case Instrument.Provided provided ->
                    sensor.put(ProviderReader.JAVA, provided.gauge().name());
            case Instrument.Lidar lidar -> {
                tree.put("rays", YamlWriter.Numeral.of(lidar.columns()));
                tree.put("angle", YamlWriter.Numeral.of(lidar.width()));
                if (lidar.rows() != 1) {
                    tree.put("rows", YamlWriter.Numeral.of(lidar.rows()));
                    tree.put("rowAngle", YamlWriter.Numeral.of(lidar.height()));
                }
                tree.put("range", YamlWriter.Numeral.of(lidar.range()));
                if (lidar.noise() != 0) {
                    tree.put("noise", YamlWriter.Numeral.of(lidar.noise()));
                }
                putSeed(tree, lidar.seed());
                sensor.put(InstrumentReader.LIDAR, tree);
            }
        }
    }

    private static void putSeed(Map<String, Object> tree, long seed) {
        if (seed != 0) {
            tree.put("seed", YamlWriter.Numeral.of((double) seed));
        }
    }

    private static void putErrors(Map<String, Object> instrument, String quantity, Errors errors) {
        Map<String, Object> tree = new LinkedHashMap<>();
        if (errors.noise() != 0) {
            tree.put("noise", YamlWriter.Numeral.of(errors.noise()));
        }
        if (errors.biasX() != 0 || errors.biasY() != 0 || errors.biasZ() != 0) {
            tree.put(
                    "bias",
                    List.of(
                            YamlWriter.Numeral.of(errors.biasX()),
                            YamlWriter.Numeral.of(errors.biasY()),
                            YamlWriter.Numeral.of(errors.biasZ())));
        }
        if (!tree.isEmpty()) {
            instrument.put(quantity, tree);
        }
    }
}
