// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.StandardSocketOptions;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;

/**
 * Two connected sockets within this process, the ends of one connection.
 *
 * @param inner the end for the event loop
 * @param outer the end for the client, in blocking mode
 */
record SocketPair(SocketChannel inner, SocketChannel outer) {

    /**
     * Maximum number of foreign connections that {@link #open} refuses while it waits for its own
     * connection. Other processes may connect to the port while it is open.
     */
    private static final int ATTEMPTS = 64;

    /**
     * Number of file descriptors that {@link #open} needs at once: the two sockets and the server
     * socket that connects them.
     */
    static final int DESCRIPTORS = 3;

    /** Size of the receive buffer of the client's end [bytes]. */
    private static final int RECEIVE_BYTES = 64 * 1024;

    /**
     * Opens the pair on the loopback address. Refuses connections of other processes, which could
     * otherwise take the place of the client's end.
     */
    static SocketPair open() throws IOException {
        try (ServerSocketChannel listening = ServerSocketChannel.open()) {
            listening.bind(new InetSocketAddress(InetAddress.ofLiteral("127.0.0.1"), 0), 1);
            SocketChannel outer = SocketChannel.open();
            outer.setOption(StandardSocketOptions.SO_RCVBUF, RECEIVE_BYTES);
            outer.connect(listening.getLocalAddress());
            for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
                SocketChannel inner = listening.accept();
                if (inner.getRemoteAddress().equals(outer.getLocalAddress())) {
                    outer.setOption(StandardSocketOptions.TCP_NODELAY, true);
                    return new SocketPair(inner, outer);
                }
                inner.close();
            }
            outer.close();
            throw new IOException("other processes connect to each port that is opened");
        }
    }
}
