// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.List;
import java.util.Map;

/**
 * The times of a frame loop since its start.
 *
 * @param frames number of completed frames
 * @param overruns number of frames that ended after the next frame was due (REAL_TIME only)
 * @param droppedFrames delay that the loop will not catch up, in frames (REAL_TIME only)
 * @param busyNanoseconds time inside frames, without waiting [ns]
 * @param phaseNanoseconds time in the listeners of each phase [ns]
 * @param framesByTime number of frames by their duration without waiting: one number for each of
 *     {@link #TIME_BOUNDS_SECONDS}, which counts the frames above the bound before and up to this
 *     bound, and the number of longer frames
 */
public record FrameProfile(
        long frames,
        long overruns,
        long droppedFrames,
        long busyNanoseconds,
        Map<FramePhase, Long> phaseNanoseconds,
        List<Long> framesByTime) {

    /** Bounds of the durations of frames by which they are counted, in ascending order [s]. */
    public static final List<Double> TIME_BOUNDS_SECONDS =
            List.of(
                    0.00025, 0.0005, 0.001, 0.002, 0.004, 0.008, 0.012, 0.016, 0.02, 0.033, 0.05,
                    0.1, 0.2, 0.5, 1.0, 2.0);

    /** Copies the map and the list. */
    public FrameProfile {
        phaseNanoseconds = Map.copyOf(phaseNanoseconds);
        framesByTime = List.copyOf(framesByTime);
    }
}
