// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.agent.port.WorldPort;
import reve.core.file.CameraDescription;

import java.util.Optional;

/** The web page that shows the worlds of a {@link WorldHost}. For any thread. */
public interface HostPage {
    /** Returns the address of the page for a browser. */
    String address();

    /**
     * Shows another world. Called before the first frame of the world.
     *
     * @param camera the first viewpoint; if empty, the page shows all bodies
     */
    void add(WorldPort port, Optional<CameraDescription> camera);

    /**
     * Shows a world no more. Called on the thread of the world, after its last frame. The page does
     * not use the world after this method has returned. Does nothing if the page has no such world.
     */
    void remove(String world);
}
