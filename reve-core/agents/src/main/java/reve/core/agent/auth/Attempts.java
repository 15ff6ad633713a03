// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import java.net.Inet6Address;
import java.net.InetAddress;
import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * Limit on wrong token secrets per network address. An address may send a burst of {@value #BURST},
 * then one per second. The server closes a connection that exceeds the limit, with the code for too
 * many attempts. Right secrets are not counted, so an attacker cannot lock out other clients at its
 * address. Only the last {@value #ADDRESSES} addresses are stored. Addresses of one IPv6 /64
 * network count as one. For any thread.
 */
public final class Attempts {

    static final int BURST = 8;
    static final int ADDRESSES = 4096;

    private static final double PER_NANO = 1e-9;
    private static final int NETWORK_BYTES = 8;

    private final Map<ByteBuffer, Left> left =
            new LinkedHashMap<>(16, 0.75f, true) {
                private static final long serialVersionUID = 1;

                @Override
                protected boolean removeEldestEntry(Map.Entry<ByteBuffer, Left> eldest) {
                    return size() > ADDRESSES;
                }
            };

    private record Left(double attempts, long atNanos) {}

    /**
     * Counts a wrong secret.
     *
     * @return false if the address has exceeded the limit
     */
    public synchronized boolean take(InetAddress address, long nowNanos) {
        ByteBuffer network = network(address);
        double now = attempts(network, nowNanos);
        if (now < 1) {
            return false;
        }
        left.put(network, new Left(now - 1, nowNanos));
        return true;
    }

    private double attempts(ByteBuffer network, long nowNanos) {
        Left before = left.get(network);
        return before == null
                ? BURST
                : Math.min(BURST, before.attempts + (nowNanos - before.atNanos) * PER_NANO);
    }

    /**
     * Returns the address for which attempts are counted. This is an IPv4 address, or the /64
     * network of an IPv6 address.
     */
    public static ByteBuffer network(InetAddress address) {
        byte[] bytes = address.getAddress();
        return ByteBuffer.wrap(
                address instanceof Inet6Address ? Arrays.copyOf(bytes, NETWORK_BYTES) : bytes);
    }
}
