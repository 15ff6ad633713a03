// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.ParameterException;

import reve.core.frame.Timing;
import reve.core.text.Rounded;

import java.util.Optional;

/** Conversion of a world time on the command line to a number of frames. */
final class Frames {
    private Frames() {}

    /**
     * Returns the frame nearest to a time [s]. Refuses negative times, and times beyond 2^53
     * frames.
     */
    static long of(CommandSpec spec, String option, double seconds, Timing timing) {
        double frames = seconds * timing.framesPerSecond();
        if (!(frames >= 0 && frames < 0x1p53)) {
            throw new ParameterException(
                    spec.commandLine(),
                    option
                            + " is "
                            + Rounded.of(seconds)
                            + ", expected a time "
                            + (frames < 0
                                    ? "of 0 s or more"
                                    : "of at most "
                                            + Rounded.of(0x1p53 / timing.framesPerSecond())
                                            + " s"));
        }
        return Math.round(frames);
    }

    /** Returns the frame nearest to a time [s], or {@code Long.MAX_VALUE} if no time is given. */
    static long of(CommandSpec spec, String option, Optional<Double> seconds, Timing timing) {
        return seconds.isPresent() ? of(spec, option, seconds.get(), timing) : Long.MAX_VALUE;
    }
}
