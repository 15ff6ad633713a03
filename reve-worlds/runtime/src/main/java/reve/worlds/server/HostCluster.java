// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.agent.port.ClusterPort;
import reve.core.agent.port.Elsewhere;

import java.util.Optional;

/** The cluster to which a {@link WorldHost} belongs. For any thread. */
public interface HostCluster extends Elsewhere, ClusterPort {
    /**
     * Returns the address (HOST:PORT) at which the agents of a world ask for it after this host has
     * closed it; empty if no server can answer. Returns at once.
     */
    Optional<String> next(String world);

    /**
     * Returns the address (HOST:PORT) of a server to which the agents of a world can connect after
     * another server has taken the world from this host; empty if this host knows no other server.
     * Returns at once.
     */
    Optional<String> refuge(String world);
}
