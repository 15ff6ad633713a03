// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import java.io.IOException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.net.SocketException;
import java.net.SocketTimeoutException;
import java.util.ArrayList;
import java.util.List;
import java.util.Random;
import java.util.concurrent.CopyOnWriteArrayList;

@Timeout(60)
class NodeDoorTest {
    private static final int MOST = 16;

    private final List<String> problems = new CopyOnWriteArrayList<>();
    private final List<Socket> opened = new ArrayList<>();
    private ServerSocket inside;
    private NodeDoor door;

    @BeforeEach
    void open() throws IOException {
        inside = new ServerSocket(0, 100, InetAddress.getLoopbackAddress());
        door =
                new NodeDoor(
                        new NodeAddress("127.0.0.1", 0),
                        (InetSocketAddress) inside.getLocalSocketAddress(),
                        MOST,
                        problems::add);
        door.open();
    }

    @AfterEach
    void close() throws IOException {
        for (Socket socket : opened) {
            socket.close();
        }
        door.close();
        inside.close();
    }

    private Socket connect() throws IOException {
        Socket socket = new Socket("127.0.0.1", door.port());
        opened.add(socket);
        return socket;
    }

    /** Accepts as Pekko does. */
    private Socket accept() throws IOException {
        inside.setSoTimeout(20_000);
        Socket socket = inside.accept();
        opened.add(socket);
        return socket;
    }

    private static boolean isOpen(Socket socket) throws IOException {
        socket.setSoTimeout(100);
        try {
            return socket.getInputStream().read() >= 0;
        } catch (SocketTimeoutException silent) {
            return true;
        } catch (SocketException reset) {
            return false;
        }
    }

    private static void awaitClosed(Socket socket) throws IOException {
        while (isOpen(socket)) {
            Thread.onSpinWait();
        }
    }

    @Test
    void bytesPassUnchangedInBothDirectionsAndTheEndToo() throws Exception {
        byte[] sent = new byte[1_000_000];
        new Random(3).nextBytes(sent);
        Socket node = connect();
        Socket pekko = accept();
        for (Socket[] way : new Socket[][] {{node, pekko}, {pekko, node}}) {
            Thread writer =
                    Thread.startVirtualThread(
                            () -> {
                                try {
                                    way[0].getOutputStream().write(sent);
                                } catch (IOException e) {
                                    throw new IllegalStateException(e);
                                }
                            });
            assertThat(way[1].getInputStream().readNBytes(sent.length)).isEqualTo(sent);
            writer.join();
        }
        node.close();
        awaitClosed(pekko);
        assertThat(problems).isEmpty();
    }

    /** Of idle connections, the oldest ones make room for new ones, and nodes stay connected. */
    @Test
    void idleConnectionsAreLimitedAndNodesStayConnected() throws Exception {
        Socket node = connect();
        Socket pekko = accept();
        byte[] proof = new byte[(int) NodeDoor.PROVEN_BYTES];
        node.getOutputStream().write(proof);
        assertThat(pekko.getInputStream().readNBytes(proof.length)).isEqualTo(proof);

        List<Socket> idle = new ArrayList<>();
        for (int i = 0; i < 10 * MOST; i++) {
            idle.add(connect());
            accept();
        }
        for (Socket early : idle.subList(0, idle.size() - MOST / 2 + 1)) {
            awaitClosed(early);
        }
        assertThat(isOpen(idle.getLast())).isTrue();
        node.getOutputStream().write(7);
        assertThat(pekko.getInputStream().read()).isEqualTo(7);
        assertThat(problems)
                .singleElement()
                .asString()
                .contains(
                        "8 come from 127.0.0.1",
                        "expected at most 16 and 8 from one address",
                        "Let only nodes reach this port");
    }

    @Test
    void thereIsRoomForOthersIfNodesHaveAllConnectionsOfTheirAddress() throws Exception {
        byte[] proof = new byte[(int) NodeDoor.PROVEN_BYTES];
        for (int i = 0; i < MOST / 2; i++) {
            Socket node = connect();
            Socket pekko = accept();
            node.getOutputStream().write(proof);
            assertThat(pekko.getInputStream().readNBytes(proof.length)).isEqualTo(proof);
        }
        awaitClosed(connect());
        try (Socket other = new Socket()) {
            other.bind(new InetSocketAddress("127.0.0.2", 0));
            other.connect(new InetSocketAddress("127.0.0.1", door.port()));
            try (Socket pekko = accept()) {
                other.getOutputStream().write(5);
                assertThat(pekko.getInputStream().read()).isEqualTo(5);
            }
        }
    }

    @Test
    void theLimitFollowsThatOfOpenFiles() {
        assertThat(NodeDoor.most(256)).isEqualTo(16);
        assertThat(NodeDoor.most(1024)).isEqualTo(32);
        assertThat(NodeDoor.most(1 << 20)).isEqualTo(256);
        assertThat(NodeDoor.most(Long.MAX_VALUE)).isEqualTo(256);
    }
}
