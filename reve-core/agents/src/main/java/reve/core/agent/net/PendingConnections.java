// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.auth.Attempts;

import java.net.InetAddress;
import java.nio.ByteBuffer;
import java.util.HashMap;
import java.util.HashSet;
import java.util.Map;
import java.util.Set;

/**
 * The connections that have not said hello yet, by their addresses, so that one address does not
 * fill all places with them. The event loop's thread.
 *
 * @param <C> a connection
 */
final class PendingConnections<C> {

    private final int mostOfAnAddress;
    private final Map<ByteBuffer, Set<C>> byNetwork = new HashMap<>();

    PendingConnections(int mostOfAnAddress) {
        this.mostOfAnAddress = mostOfAnAddress;
    }

    /** True if one more from that address may come. */
    boolean haveRoomFor(InetAddress address) {
        return byNetwork.getOrDefault(Attempts.network(address), Set.of()).size() < mostOfAnAddress;
    }

    void add(InetAddress address, C connection) {
        byNetwork
                .computeIfAbsent(Attempts.network(address), network -> new HashSet<>())
                .add(connection);
    }

    /** It has said hello, or gone. Does nothing if it was not there. */
    void remove(InetAddress address, C connection) {
        byNetwork.computeIfPresent(
                Attempts.network(address),
                (network, connections) -> {
                    connections.remove(connection);
                    return connections.isEmpty() ? null : connections;
                });
    }
}
