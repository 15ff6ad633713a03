// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.port;

import java.util.List;
import java.util.Map;
import java.util.Optional;

/** The worlds of other servers, to which a server sends clients. */
@FunctionalInterface
public interface Elsewhere {
    /** The value for a server without other servers. */
    Elsewhere NOWHERE = Map::of;

    /** The value for a server that does not know the worlds of other servers yet. */
    Elsewhere UNKNOWN =
            new Elsewhere() {
                @Override
                public Map<String, String> worlds() {
                    return Map.of();
                }

                @Override
                public boolean isComplete() {
                    return false;
                }
            };

    /**
     * Returns the addresses (HOST:PORT) of the worlds of other servers, by name. The address is
     * empty while no server is ready to serve the world. Called on the event loop's thread; must
     * return at once.
     */
    Map<String, String> worlds();

    /**
     * Returns whether {@link #worlds} contains all worlds of other servers. Until then, a client
     * that asks for another world must try again. Called on the event loop's thread; must return at
     * once.
     */
    default boolean isComplete() {
        return true;
    }

    /**
     * Returns the addresses (HOST:PORT) of other servers at which clients of this server ask for
     * their worlds if this server is lost. For any thread; must return at once.
     */
    default List<String> servers() {
        return List.of();
    }

    /**
     * Returns the cluster of this server; empty if it belongs to none. For any thread; must return
     * at once.
     */
    default Optional<ClusterPort> cluster() {
        return Optional.empty();
    }

    /**
     * Reports that a client asks for a world whose address is empty, and may join it. A world that
     * sleeps begins to run. Called on the event loop's thread; must return at once.
     */
    default void wanted(String world) {
        // The worlds of most servers run without being asked for.
    }

    /**
     * Returns whether this server runs no worlds, but shows copies of the worlds of other servers
     * to observers. All other clients are referred to the servers that run the worlds. For any
     * thread; must return at once.
     */
    default boolean isWatching() {
        return false;
    }

    /**
     * Reports that an observer asks for a world of which this server has no copy yet, and may join
     * it. Called on the event loop's thread; must return at once.
     *
     * @return what the client can do, if this server cannot copy the world; empty if it copies it
     */
    default Optional<String> watched(String world) {
        return Optional.of("this server only has worlds of its own");
    }

    /**
     * Returns the address (HOST:PORT) of another server at which an observer joins a world, because
     * it shows a copy of the world; empty if the observer joins here. The address is the same for
     * each attempt of the observer. Called on the event loop's thread; must return at once.
     */
    default Optional<String> forObserver(String world, String client) {
        return Optional.empty();
    }
}
