// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** A callback for one phase of each frame. */
@FunctionalInterface
public interface FrameListener {

    /**
     * Handles one phase of a frame. Called on the world's thread; must not retain the event. The
     * frame and all clients wait until it returns, so it must not sleep or wait for files, sockets
     * or locks; use another thread for such work. A listener that blocks is not interrupted. An
     * exception is reported as a "fault", and the other listeners are still called.
     */
    void onFrame(FrameEvent event);
}
