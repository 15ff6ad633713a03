// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The parts of a frame, in the order they run, all on the world's thread. */
public enum FramePhase {
    /** Takes queued commands into this frame, in a fixed order. */
    INTAKE(true),
    /** Executes them: joins, actions, law changes. */
    ACT(true),
    /** Exactly one listener, the physics adapter, advances the world. */
    PHYSICS(false),
    /** Works out derived properties. */
    DERIVE(false),
    /** Hands a snapshot to readers. */
    PUBLISH(false);

    private final boolean structureMayChange;

    FramePhase(boolean structureMayChange) {
        this.structureMayChange = structureMayChange;
    }

    /** True where items may be added and removed. */
    public boolean structureMayChange() {
        return structureMayChange;
    }
}
