// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** A callback for one phase of each frame. */
@FunctionalInterface
public interface FrameListener {

    /**
     * Handles one phase of a frame on the world's thread. The listener must not retain the event.
     *
     * <p>The frame and all clients wait until this method returns. It must therefore not sleep or
     * wait for files, sockets or locks, but use another thread for such work. A listener that
     * blocks is not interrupted. An exception is reported as a "fault", and the other listeners are
     * still called.
     */
    void onFrame(FrameEvent event);
}
