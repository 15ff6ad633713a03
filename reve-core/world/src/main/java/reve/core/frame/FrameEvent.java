// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import reve.core.world.World;

/**
 * The data of a frame for listeners. One object serves all calls of listeners and is valid only
 * during each call.
 */
public final class FrameEvent {

    private final World world;
    private final Timing timing;
    private long frame;
    private FramePhase phase = FramePhase.INTAKE;

    FrameEvent(World world, Timing timing) {
        this.world = world;
        this.timing = timing;
    }

    /**
     * Returns the number of the frame, from 1. It is 0 while the phases DERIVE and PUBLISH run for
     * the initial world. A rewind restores an earlier time, but this number still increases.
     */
    public long frame() {
        return frame;
    }

    /** Returns the current phase of the frame. */
    public FramePhase phase() {
        return phase;
    }

    /** Returns the simulated time at the end of this frame [s]. */
    public double timeSeconds() {
        return timing.timeSeconds(world.age());
    }

    /** Returns the length of one physics step [s]. */
    public double dtSeconds() {
        return timing.dtSeconds();
    }

    /** Returns the number of physics steps per frame. */
    public int steps() {
        return timing.stepsPerFrame();
    }

    /** Returns the world of the frame. */
    public World world() {
        return world;
    }

    void set(long newFrame, FramePhase newPhase) {
        frame = newFrame;
        phase = newPhase;
    }
}
