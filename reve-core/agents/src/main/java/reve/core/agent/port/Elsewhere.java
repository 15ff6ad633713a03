// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import java.util.Map;

/** The worlds of other servers, to which a server sends clients. */
@FunctionalInterface
public interface Elsewhere {
    /** There are no other servers. */
    Elsewhere NOWHERE = Map::of;

    /**
     * Returns the addresses (HOST:PORT) of the worlds of other servers, by name. The address is
     * empty while no server is ready to serve the world. Called on the event loop's thread; must
     * return at once.
     */
    Map<String, String> worlds();
}
