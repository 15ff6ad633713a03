// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The parts of a frame in order of execution, all on the world's thread. */
public enum FramePhase {
    /** Takes queued commands into this frame, in a fixed order. */
    INTAKE(true),
    /** Executes the commands: joins, actions, law changes. */
    ACT(true),
    /** Advances the world. The only listener of this phase is the physics adapter. */
    PHYSICS(false),
    /** Computes derived properties. */
    DERIVE(false),
    /** Passes a snapshot to readers. */
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
