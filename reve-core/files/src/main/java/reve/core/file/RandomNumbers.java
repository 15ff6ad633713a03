// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.Map;

/**
 * Pseudorandom numbers from a seed and the number of a repetition. Uses SplitMix64 (G. L. Steele,
 * D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, 2014).
 */
final class RandomNumbers {
    /** The random functions of formulas. Their argument is the seed. */
    static final Map<String, Function> FUNCTIONS =
            Map.of(
                    "random", numbers -> new double[] {numbers.next()},
                    "box", RandomNumbers::inBox,
                    "ball", RandomNumbers::inBall,
                    "sphere", RandomNumbers::onSphere);

    private static final long STEP = 0x9e3779b97f4a7c15L;

    /**
     * Minimum squared distance from the origin of a random point that determines a direction. The
     * coordinates of nearer points have too few significant digits.
     */
    private static final double SMALLEST = 1e-6;

    /** A random function. It returns one number, or the coordinates of a point. */
    interface Function {
        double[] value(RandomNumbers numbers);
    }

    private long state;

    RandomNumbers(long seed, long number) {
        state = mixed(mixed(seed) + number);
    }

    /** Returns a uniform number from 0 (inclusive) to 1 (exclusive). */
    double next() {
        state += STEP;
        return (mixed(state) >>> 11) * 0x1p-53;
    }

    /** Returns a uniform point in the cube from -1 to 1. */
    private double[] inBox() {
        return new double[] {2 * next() - 1, 2 * next() - 1, 2 * next() - 1};
    }

    /**
     * Returns a uniform point in the ball of radius 1. It is the first random point of the cube
     * that is inside the ball.
     */
    private double[] inBall() {
        double[] point = inBox();
        while (squared(point) > 1) {
            point = inBox();
        }
        return point;
    }

    /** Returns a uniform point on the sphere of radius 1. */
    private double[] onSphere() {
        double[] point = inBall();
        while (squared(point) < SMALLEST) {
            point = inBall();
        }
        double radius = Math.sqrt(squared(point));
        return new double[] {point[0] / radius, point[1] / radius, point[2] / radius};
    }

    private static double squared(double[] point) {
        return point[0] * point[0] + point[1] * point[1] + point[2] * point[2];
    }

    private static long mixed(long bits) {
        long z = (bits ^ bits >>> 30) * 0xbf58476d1ce4e5b9L;
        z = (z ^ z >>> 27) * 0x94d049bb133111ebL;
        return z ^ z >>> 31;
    }
}
