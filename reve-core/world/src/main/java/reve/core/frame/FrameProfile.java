// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Map;

/**
 * The times of a frame loop since its start.
 *
 * @param frames number of completed frames
 * @param overruns number of frames that ended after the next frame was due (REAL_TIME only)
 * @param droppedFrames delay that the loop will not catch up, in frames (REAL_TIME only)
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
