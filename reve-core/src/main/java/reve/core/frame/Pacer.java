// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.concurrent.atomic.AtomicLong;

/**
 * Decides when the next frame is due. Deadlines are products on the monotonic clock, so waiting
 * late once does not make everything after it late.
 */
final class Pacer {

    private static final long SECOND = 1_000_000_000L;

    private final Timing timing;
    private final Pacing pacing;
    private final FrameClock clock;
    private final AtomicLong overruns = new AtomicLong();
    private final AtomicLong droppedFrames = new AtomicLong();
    private long originNanoseconds;
    private long framesSinceOrigin;

    Pacer(Timing timing, Pacing pacing, FrameClock clock) {
        this.timing = timing;
        this.pacing = pacing;
        this.clock = clock;
    }

    /** The first frame begins now. */
    void start() {
        originNanoseconds = clock.nanoTime();
        framesSinceOrigin = 0;
    }

    /** A frame was made; the next is due when its share of wall time is over. */
    void frameDone() {
        framesSinceOrigin++;
        if (pacing == Pacing.FAST) {
            return;
        }
        long late = -nanosecondsToWait();
        if (late > 0) {
            overruns.setRelease(overruns.getPlain() + 1);
        }
        int perSecond = timing.framesPerSecond();
        long framesLate = late / SECOND * perSecond + late % SECOND * perSecond / SECOND;
        long given = framesLate - FrameLoop.MAX_CATCH_UP_FRAMES;
        if (given > 0) {
            framesSinceOrigin += given;
            droppedFrames.setRelease(droppedFrames.getPlain() + given);
        }
    }

    /** Time until the next frame is due [ns]; 0 or less if it is. */
    long nanosecondsToWait() {
        if (pacing == Pacing.FAST) {
            return 0;
        }
        return originNanoseconds + due(framesSinceOrigin) - clock.nanoTime();
    }

    long overruns() {
        return overruns.getAcquire();
    }

    long droppedFrames() {
        return droppedFrames.getAcquire();
    }

    /** Offset of a frame's beginning from the origin [ns], without overflow for centuries. */
    private long due(long frame) {
        int perSecond = timing.framesPerSecond();
        return frame / perSecond * SECOND + frame % perSecond * SECOND / perSecond;
    }
}
