// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import java.net.InetAddress;
import java.net.UnknownHostException;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * The address at which the other nodes of a cluster reach a node.
 *
 * @param host name or IPv4 address
 * @param port 0 selects a free port
 */
public record NodeAddress(String host, int port) {
    private static final Pattern TEXT =
            Pattern.compile("(?<host>[A-Za-z0-9._-]+):(?<port>[0-9]{1,5})");

    private static final int MAX_PORT = 65_535;

    /**
     * Returns the address in a text such as {@code 10.0.0.1:2551}.
     *
     * @throws IllegalArgumentException if the text is no such address
     */
    public static NodeAddress parse(String text) {
        Matcher parts = TEXT.matcher(text);
        if (!parts.matches() || Integer.parseInt(parts.group("port")) > MAX_PORT) {
            throw new IllegalArgumentException(
                    "found '"
                            + text
                            + "', expected HOST:PORT with a name or an IPv4 address, for example"
                            + " 127.0.0.1:2551");
        }
        return new NodeAddress(parts.group("host"), Integer.parseInt(parts.group("port")));
    }

    /**
     * Returns whether only programs of this machine reach the address.
     *
     * @throws UnknownHostException if the host has no address
     */
    public boolean isLoopback() throws UnknownHostException {
        for (InetAddress each : InetAddress.getAllByName(host)) {
            if (!each.isLoopbackAddress()) {
                return false;
            }
        }
        return true;
    }

    /** Returns whether the address stands for all addresses of a machine. */
    public boolean isWildcard() throws UnknownHostException {
        return InetAddress.getByName(host).isAnyLocalAddress();
    }

    @Override
    public String toString() {
        return host + ":" + port;
    }
}
