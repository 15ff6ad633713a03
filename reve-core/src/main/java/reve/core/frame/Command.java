// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import reve.core.world.World;

/** Something that wants to be done to the world, from any thread, once, in ACT of some frame. */
public interface Command {

    /** Declared name of who asks; commands of one frame are ordered by it first. */
    String origin();

    /** Rises with every command of an origin; orders them. */
    long sequence();

    /**
     * True if it need not wait for a frame: it is executed between two frames where that comes
     * sooner, see {@link FrameLoop#executePrompt}.
     */
    default boolean isPrompt() {
        return false;
    }

    /**
     * True if the command is not to be executed in this frame. Then it waits for the next one, and
     * so does all that its origin has said after it. Asked in ACT.
     */
    default boolean mustWait(FrameEvent event) {
        return false;
    }

    /** Called on the world's thread in ACT. What it throws is reported and harms nobody else. */
    void execute(World world, FrameEvent event);
}
