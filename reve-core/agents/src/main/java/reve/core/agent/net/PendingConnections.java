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
 * The connections that have not sent hello yet, by network address. Their number is limited per
 * address, so that one address cannot take all places. For the event loop's thread only.
 *
 * @param <C> type of a connection
 */
final class PendingConnections<C> {

    private final int mostOfAnAddress;
    private final Map<ByteBuffer, Set<C>> byNetwork = new HashMap<>();

    PendingConnections(int mostOfAnAddress) {
        this.mostOfAnAddress = mostOfAnAddress;
    }

    /** Returns whether one more connection from that address is allowed. */
    boolean haveRoomFor(InetAddress address) {
        return byNetwork.getOrDefault(Attempts.network(address), Set.of()).size() < mostOfAnAddress;
    }

    void add(InetAddress address, C connection) {
        byNetwork
                .computeIfAbsent(Attempts.network(address), network -> new HashSet<>())
                .add(connection);
    }

    /**
     * Removes a connection that has sent hello or has ended. Does nothing if the connection is
     * absent.
     */
    void remove(InetAddress address, C connection) {
        byNetwork.computeIfPresent(
                Attempts.network(address),
                (network, connections) -> {
                    connections.remove(connection);
                    return connections.isEmpty() ? null : connections;
                });
    }
}
