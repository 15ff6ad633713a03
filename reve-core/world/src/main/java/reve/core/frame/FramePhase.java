// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The parts of a frame in order of execution, all on the world's thread. */
public enum FramePhase {
    /** Phase that takes queued commands into this frame, in a fixed order. */
    INTAKE(true),
    /** Phase that executes the commands: joins, actions and changes of laws. */
    ACT(true),
    /** Phase that advances the world. Its only listener is the physics adapter. */
    PHYSICS(false),
    /** Phase that computes derived properties. */
    DERIVE(false),
    /** Phase that passes a snapshot to readers. */
    PUBLISH(false);

    private final boolean structureMayChange;

    FramePhase(boolean structureMayChange) {
        this.structureMayChange = structureMayChange;
    }

    /** Returns true if items may be added and removed in this phase. */
    public boolean structureMayChange() {
        return structureMayChange;
    }
}
