// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

/**
 * The operations on a world that only the frame loop and the first listener of DERIVE need, and
 * tests that make frames by hand. World's thread only.
 */
public final class FrameControl {

    private final WorldData data;
    private final Forces forces;

    FrameControl(WorldData data, Forces forces) {
        this.data = data;
        this.forces = forces;
    }

    /** Returns the frame control of a world. */
    public static FrameControl of(World world) {
        return world.frameControl();
    }

    /** Sets how fast the world's frames follow each other in its own time. */
    public void setFramesPerSecond(int framesPerSecond) {
        forces.setFramesPerSecond(framesPerSecond);
    }

    /** Begins a frame: the world is one frame older. */
    public void begin() {
        data.guard.checkOwner();
        data.age++;
    }

    /** Refuses structural changes until {@link #unlock()}; the phase appears in messages. */
    public void lock(String phase) {
        data.guard.lockStructure(phase);
    }

    /** Permits structural changes. */
    public void unlock() {
        data.guard.unlockStructure();
    }

    /** Adds the lasting forces to what laws see, before PHYSICS. */
    public void applyForces() {
        forces.apply();
    }

    /**
     * Ends PHYSICS: takes the lasting forces out again, to the bit, and frees column memory that
     * was replaced, as all have rebound by then.
     */
    public void endPhysics() {
        data.guard.checkOwner();
        forces.withdraw();
        data.layout.releaseReplaced();
    }

    /** Puts what is attached where its parents are; in DERIVE, before anything looks. */
    public void placeAttached() {
        data.guard.checkOwner();
        data.hierarchy.place();
    }

    /** Notes that the boxes around bodies were worked out anew, in DERIVE. */
    public void boundsDerived() {
        data.guard.checkOwner();
        data.boundsChanged();
    }

    /** Begins PUBLISH: what is raised or changed from now on belongs to the next frame. */
    public void publish() {
        data.guard.checkOwner();
        data.record.fix();
    }

    /**
     * Ends a frame: forgets its events and changes, published or not, and unlocks the structure.
     */
    public void end() {
        data.guard.checkOwner();
        data.record.end();
        data.guard.unlockStructure();
    }
}
