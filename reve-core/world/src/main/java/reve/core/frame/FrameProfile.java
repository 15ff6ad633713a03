// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Map;

/**
 * The times of a frame loop since its start.
 *
 * @param frames frames completed
 * @param overruns frames that ended after the next one was due (REAL_TIME only)
 * @param droppedFrames number of frames by which the loop gave up catching up with the wall clock
 *     (REAL_TIME only)
 * @param busyNanoseconds time inside frames, without waiting [ns]
 * @param phaseNanoseconds time in the listeners of each phase [ns]
 */
public record FrameProfile(
        long frames,
        long overruns,
        long droppedFrames,
        long busyNanoseconds,
        Map<FramePhase, Long> phaseNanoseconds) {

    /** Copies the map. */
    public FrameProfile {
        phaseNanoseconds = Map.copyOf(phaseNanoseconds);
    }
}
