// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** Something that takes part in frames. */
@FunctionalInterface
public interface FrameListener {

    /**
     * Called on the world's thread, in the phase subscribed to; must not keep the event. The frame,
     * and with it everybody in the world, waits until it returns: it neither sleeps nor waits for
     * files, sockets or locks, but leaves such work to a thread of its own. Nothing ends one that
     * does; what it throws is a "fault", and the others are called all the same.
     */
    void onFrame(FrameEvent event);
}
