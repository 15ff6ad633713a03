// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.concurrent.atomic.AtomicLong;

/**
 * The schedule of frames on the monotonic clock. Frame n is due at the start plus n times the
 * duration of a frame, so one late wake-up does not delay later frames.
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

    /** The requested speed: simulated time divided by time of the clock. */
    private volatile double speed = 1;

    /** The speed for which the present schedule was computed. */
    private double scheduledSpeed = 1;

    Pacer(Timing timing, Pacing pacing, FrameClock clock) {
        this.timing = timing;
        this.pacing = pacing;
        this.clock = clock;
    }

    /** Starts the schedule. The first frame is due now. */
    void start() {
        originNanoseconds = clock.nanoTime();
        framesSinceOrigin = 0;
        scheduledSpeed = speed;
    }

    /**
     * Changes the speed. The schedule restarts at the next call of {@link #nanosecondsToWait}. For
     * any thread.
     */
    void setSpeed(double factor) {
        if (!(factor > 0 && Double.isFinite(factor))) {
            throw new IllegalArgumentException(
                    "speed is " + factor + ", expected a finite number above 0");
        }
        speed = factor;
    }

    double speed() {
        return speed;
    }

    /**
     * Advances the schedule by one frame. The loop may be late by more than {@link
     * FrameLoop#MAX_CATCH_UP_FRAMES} frames. The schedule is then moved, so that the loop is late
     * by this number only.
     */
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
        long framesLate =
                scheduledSpeed == 1
                        ? late / SECOND * perSecond + late % SECOND * perSecond / SECOND
                        : (long) (late * scheduledSpeed * perSecond / SECOND);
        long given = framesLate - FrameLoop.MAX_CATCH_UP_FRAMES;
        if (given > 0) {
            framesSinceOrigin += given;
            droppedFrames.setRelease(droppedFrames.getPlain() + given);
        }
    }

    /** Returns the time until the next frame is due [ns]; 0 or less if it is due. */
    long nanosecondsToWait() {
        if (pacing == Pacing.FAST) {
            return 0;
        }
        if (scheduledSpeed != speed) {
            start();
            framesSinceOrigin = 1; // counts the frame that was just made
        }
        return originNanoseconds + due(framesSinceOrigin) - clock.nanoTime();
    }

    long overruns() {
        return overruns.getAcquire();
    }

    long droppedFrames() {
        return droppedFrames.getAcquire();
    }

    /**
     * Returns the time from the start of the schedule to the start of a frame [ns]. The result does
     * not overflow for centuries.
     */
    private long due(long frame) {
        int perSecond = timing.framesPerSecond();
        if (scheduledSpeed != 1) {
            return (long) (frame * (SECOND / (perSecond * scheduledSpeed)));
        }
        return frame / perSecond * SECOND + frame % perSecond * SECOND / perSecond;
    }
}
