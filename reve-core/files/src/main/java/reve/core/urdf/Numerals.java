// SPDX-License-Identifier: Apache-2.0
package reve.core.urdf;

import reve.core.file.YamlWriter.Numeral;
import reve.core.world.Pose;

import java.math.BigDecimal;
import java.math.MathContext;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** Numbers of a robot in the form in which a world file contains them. */
final class Numerals {
    private static final double DIGITS = 1e12;
    private static final MathContext TWELVE_DIGITS = new MathContext(12);
    private static final double NOISE = 1e-14;

    private Numerals() {}

    /** Adds a location and an orientation to the physical aspect of an item. */
    static void putPose(Map<String, Object> item, Map<String, Object> physical, Pose pose) {
        physical.put("location", rounded(pose.location()));
        if (Math.abs(pose.qw()) < 1) {
            physical.put("orientation", exactly(withoutNoise(pose.orientation())));
        }
        item.put("physical", physical);
    }

    static List<Numeral> exactly(double[] values) {
        List<Numeral> numerals = new ArrayList<>();
        for (double value : values) {
            numerals.add(Numeral.of(value == 0 ? 0 : value));
        }
        return numerals;
    }

    /** Returns the values, rounded to 12 significant digits. */
    static List<Numeral> shortened(double[] values) {
        List<Numeral> numerals = new ArrayList<>();
        for (double value : values) {
            numerals.add(Numeral.of(new BigDecimal(value).round(TWELVE_DIGITS).doubleValue()));
        }
        return numerals;
    }

    /** Returns the values, with 0 instead of rounding errors. */
    static double[] withoutNoise(double[] values) {
        double[] clean = values.clone();
        for (int i = 0; i < clean.length; i++) {
            clean[i] = Math.abs(clean[i]) < NOISE ? 0 : clean[i];
        }
        return clean;
    }

    /**
     * Returns the values, rounded to 12 decimal places. This removes rounding errors of simple
     * numbers such as 0.1.
     */
    static List<Numeral> rounded(double[] values) {
        List<Numeral> numerals = new ArrayList<>();
        for (double value : values) {
            numerals.add(Numeral.of(round(value)));
        }
        return numerals;
    }

    /**
     * Returns a value, rounded to 12 decimal places. This removes rounding errors of simple numbers
     * such as 0.1.
     */
    static double round(double value) {
        double round = Math.rint(value * DIGITS) / DIGITS;
        return round == 0 ? 0 : round;
    }
}
