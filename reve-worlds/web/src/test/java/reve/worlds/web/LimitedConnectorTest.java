// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import static org.assertj.core.api.Assertions.assertThat;

import org.eclipse.jetty.server.ConnectionFactory;
import org.eclipse.jetty.server.HttpConnectionFactory;
import org.eclipse.jetty.server.Server;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.nio.charset.StandardCharsets;

/** Connections to the web port beyond its limits. */
class LimitedConnectorTest {

    private static final int MOST = 4;
    private static final int MOST_OF_ADDRESS = 3;

    private final Server server = new Server();
    private LimitedConnector connector;
    private int descriptors = 100;

    private void start() throws Exception {
        connector =
                new LimitedConnector(
                        server,
                        new Visitors(MOST, () -> descriptors-- > 0),
                        new ConnectionFactory[] {new HttpConnectionFactory()});
        connector.setHost("127.0.0.1");
        server.addConnector(connector);
        server.start();
    }

    @AfterEach
    void stop() throws Exception {
        server.stop();
    }

    private Socket connect(String from) throws IOException {
        var socket = new Socket();
        socket.setSoTimeout(20_000);
        socket.bind(new InetSocketAddress(InetAddress.ofLiteral(from), 0));
        socket.connect(new InetSocketAddress("127.0.0.1", connector.getLocalPort()));
        return socket;
    }

    /** Returns whether the server answers a request. */
    private static boolean isServed(Socket socket) throws IOException {
        try {
            socket.getOutputStream()
                    .write("GET / HTTP/1.1\r\nHost: x\r\n\r\n".getBytes(StandardCharsets.US_ASCII));
            return socket.getInputStream().read() == 'H';
        } catch (java.net.SocketException reset) {
            return false;
        }
    }

    @Test
    void oneAddressLeavesRoomForOthersAndAClosedConnectionMakesRoom() throws Exception {
        start();
        var open = new Socket[MOST_OF_ADDRESS];
        try {
            for (int i = 0; i < open.length; i++) {
                open[i] = connect("127.0.0.1");
                assertThat(isServed(open[i])).isTrue();
            }
            try (Socket tooMany = connect("127.0.0.1")) {
                assertThat(isServed(tooMany)).isFalse();
            }
            try (Socket other = connect("127.0.0.2")) {
                assertThat(isServed(other)).isTrue();
                try (Socket full = connect("127.0.0.3")) {
                    assertThat(isServed(full)).isFalse();
                }
            }
            open[0].shutdownOutput();
            assertThat(open[0].getInputStream().readAllBytes()).isNotEmpty();
            try (Socket next = connect("127.0.0.1")) {
                assertThat(isServed(next)).isTrue();
            }
        } finally {
            for (Socket socket : open) {
                if (socket != null) {
                    socket.close();
                }
            }
        }
    }

    @Test
    void theReserveOfDescriptorsIsKept() throws Exception {
        descriptors = 1;
        start();
        try (Socket first = connect("127.0.0.1");
                Socket second = connect("127.0.0.1")) {
            assertThat(isServed(first)).isTrue();
            assertThat(isServed(second)).isFalse();
        }
    }
}
