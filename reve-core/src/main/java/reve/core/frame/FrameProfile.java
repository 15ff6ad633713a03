// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.Map;

/**
 * Where a frame loop's time went, from its start until now.
 *
 * @param frames frames completed
 * @param overruns frames that ended after the next one was due (REAL_TIME only)
 * @param droppedFrames frames of wall time given up because catching up is bounded (REAL_TIME only)
 * @param busyNanoseconds time inside frames, without waiting [ns]
 * @param phaseNanoseconds time in the listeners of each phase [ns]
 */
public record FrameProfile(
        long frames,
        long overruns,
        long droppedFrames,
        long busyNanoseconds,
        Map<FramePhase, Long> phaseNanoseconds) {

    public FrameProfile {
        phaseNanoseconds = Map.copyOf(phaseNanoseconds);
    }
}
