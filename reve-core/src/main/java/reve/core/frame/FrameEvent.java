// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import reve.core.world.World;

/** What a listener is told. One object serves all calls: valid during the call only. */
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
     * 1 for the first frame; 0 while the world as it was built is derived and published. It never
     * goes back, as time does when the world goes back to an image.
     */
    public long frame() {
        return frame;
    }

    public FramePhase phase() {
        return phase;
    }

    /** Simulated time at the end of this frame [s]. */
    public double timeSeconds() {
        return timing.timeSeconds(world.age());
    }

    /** Length of one physics step [s]. */
    public double dtSeconds() {
        return timing.dtSeconds();
    }

    /** Physics steps per frame. */
    public int steps() {
        return timing.stepsPerFrame();
    }

    public World world() {
        return world;
    }

    void set(long newFrame, FramePhase newPhase) {
        frame = newFrame;
        phase = newPhase;
    }
}
