// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/**
 * The division of simulated time into frames and steps.
 *
 * @param framesPerSecond frames per simulated second, 1 to 10,000
 * @param stepsPerFrame physics steps per frame, 1 to 10,000
 */
public record Timing(int framesPerSecond, int stepsPerFrame) {

    /** 60 frames per second with one step each. */
    public static final Timing DEFAULT = new Timing(60, 1);

    /** Checks that both numbers are in their range. */
    public Timing {
        requireRange("frames per second", framesPerSecond);
        requireRange("steps per frame", stepsPerFrame);
    }

    /** Returns the length of one physics step [s]. */
    public double dtSeconds() {
        return 1.0 / ((double) framesPerSecond * stepsPerFrame);
    }

    /**
     * Returns the simulated time at the end of a frame [s]. It is a product, not a sum, so rounding
     * errors do not add up.
     */
    public double timeSeconds(long frame) {
        return frame * stepsPerFrame * dtSeconds();
    }

    private static void requireRange(String what, int value) {
        if (value < 1 || value > 10_000) {
            throw new IllegalArgumentException(what + " is " + value + ", expected 1 to 10000");
        }
    }
}
