// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.auth;

import java.net.Inet6Address;
import java.net.InetAddress;
import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * Bounds how often clients of one address may offer a wrong secret: {@value #BURST} times at once,
 * then one time a second. What is wrong beyond that is cut as too much; a right secret is never
 * asked about here, so that an attacker does not lock out others of its address. Remembers the last
 * {@value #ADDRESSES} addresses; those of one IPv6 network of 64 bits count as one. Any thread.
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

    /** Counts a wrong secret. @return false if there were too many from that address */
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

    /** Those of one IPv6 network of 64 bits count as one. */
    public static ByteBuffer network(InetAddress address) {
        byte[] bytes = address.getAddress();
        return ByteBuffer.wrap(
                address instanceof Inet6Address ? Arrays.copyOf(bytes, NETWORK_BYTES) : bytes);
    }
}
