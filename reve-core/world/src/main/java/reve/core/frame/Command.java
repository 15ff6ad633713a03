// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import reve.core.world.World;

/**
 * A request to change the world. Any thread may queue it. The world executes it once, in the phase
 * ACT of a frame.
 */
public interface Command {

    /**
     * Returns the name of the sender. Commands of one frame are executed in order of origin, then
     * of {@link #sequence}.
     */
    String origin();

    /** Returns a number that increases from command to command of one origin. */
    long sequence();

    /**
     * Returns true if the command may be executed between two frames, see {@link
     * FrameLoop#executePrompt}. All other commands wait for a frame.
     */
    default boolean isPrompt() {
        return false;
    }

    /**
     * Returns true if the command must wait for the next frame. Later commands of the same origin
     * then wait, too. Called in the phase ACT.
     */
    default boolean mustWait(FrameEvent event) {
        return false;
    }

    /**
     * Returns true if the execution may take milliseconds. The costly commands of one frame share a
     * time limit. Commands that exceed it wait for later frames.
     */
    default boolean isCostly() {
        return false;
    }

    /**
     * Executes the command. Called on the world's thread in the phase ACT. An exception is reported
     * and does not affect other commands.
     */
    void execute(World world, FrameEvent event);
}
