// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.net.InetAddress;
import java.nio.ByteBuffer;
import java.util.HashMap;
import java.util.HashSet;
import java.util.Map;
import java.util.Set;

/**
 * The connections that have not said hello yet, by their addresses, so that one address does not
 * fill all places with them. The event loop's thread.
 */
final class Strangers {

    private final int mostOfAnAddress;
    private final Map<ByteBuffer, Set<Connection>> byNetwork = new HashMap<>();

    Strangers(int mostOfAnAddress) {
        this.mostOfAnAddress = mostOfAnAddress;
    }

    /** True if one more from that address may come. */
    boolean haveRoomFor(InetAddress address) {
        return byNetwork.getOrDefault(Attempts.network(address), Set.of()).size() < mostOfAnAddress;
    }

    void add(Connection connection) {
        byNetwork
                .computeIfAbsent(Attempts.network(connection.address()), network -> new HashSet<>())
                .add(connection);
    }

    /** It has said hello, or gone. Does nothing if it was not there. */
    void remove(Connection connection) {
        byNetwork.computeIfPresent(
                Attempts.network(connection.address()),
                (network, its) -> {
                    its.remove(connection);
                    return its.isEmpty() ? null : its;
                });
    }
}
