// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.ItemId;

/**
 * The noise of one measurement: a sequence of independent, normally distributed numbers. The
 * sequence depends only on the arguments of the constructor and has the same bits on every machine.
 * For one thread.
 *
 * <p>The generator is SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, <i>Fast splittable
 * pseudorandom number generators</i>, OOPSLA 2014), followed by the transformation of G. E. P. Box
 * and M. E. Muller, <i>A note on the generation of random normal deviates</i>, Ann. Math. Stat. 29
 * (1958) 610.
 */
final class MeasurementNoise {

    private static final long GOLDEN = 0x9E3779B97F4A7C15L;

    private long state;

    /**
     * @param time simulated time of the world [s]; a rewind restores it, so the noise repeats
     */
    MeasurementNoise(long seed, ItemId item, String sensor, double time) {
        state = mixed(seed + GOLDEN);
        state = mixed(state ^ item.value());
        state = mixed(state ^ sensor.hashCode());
        state = mixed(state ^ Double.doubleToRawLongBits(time));
    }

    /**
     * Returns the next number.
     *
     * @param deviation standard deviation, 0 or more
     */
    double next(double deviation) {
        double radius = StrictMath.sqrt(-2 * StrictMath.log(uniform()));
        double angle = 2 * Math.PI * uniform();
        return deviation == 0 ? 0 : deviation * radius * StrictMath.cos(angle);
    }

    /** Returns a number above 0, and at most 1, on a grid of 2^-53. */
    private double uniform() {
        state += GOLDEN;
        return ((mixed(state) >>> 11) + 1) * 0x1p-53;
    }

    private static long mixed(long bits) {
        long mixed = (bits ^ bits >>> 30) * 0xBF58476D1CE4E5B9L;
        mixed = (mixed ^ mixed >>> 27) * 0x94D049BB133111EBL;
        return mixed ^ mixed >>> 31;
    }
}
