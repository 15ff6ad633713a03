// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.SocketAddress;
import java.nio.channels.SocketChannel;
import java.util.HashSet;
import java.util.Set;
import java.util.function.BooleanSupplier;

/**
 * The open connections of the web port, and their limits. There are limits on their total number,
 * on the number from one address, and on the file descriptors of the process. For any thread.
 */
final class Visitors {

    private final int most;
    private final int mostOfAddress;
    private final BooleanSupplier takeDescriptor;

    /** The open connections. Guarded by this object's lock. */
    private final Set<SocketChannel> open = new HashSet<>();

    /**
     * @param most maximum number of open connections; one address may have three quarters of them
     * @param takeDescriptor reserves a file descriptor; returns false if none is left for
     *     connections
     */
    Visitors(int most, BooleanSupplier takeDescriptor) {
        this.most = most;
        this.mostOfAddress = Math.max(1, most - most / 4);
        this.takeDescriptor = takeDescriptor;
    }

    /**
     * Returns whether an accepted connection may stay open. If so, counts the connection until it
     * is closed.
     */
    synchronized boolean admit(SocketChannel accepted) throws IOException {
        open.removeIf(channel -> !channel.isOpen());
        SocketAddress remote = accepted.getRemoteAddress();
        if (!(remote instanceof InetSocketAddress address) || open.size() >= most) {
            return false;
        }
        int ofAddress = 0;
        for (SocketChannel channel : open) {
            if (channel.socket().getInetAddress().equals(address.getAddress())) {
                ofAddress++;
            }
        }
        if (ofAddress >= mostOfAddress || !takeDescriptor.getAsBoolean()) {
            return false;
        }
        open.add(accepted);
        return true;
    }
}
