// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.util.Random;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.atomic.AtomicInteger;

/**
 * A relay to a local server. It breaks each connection after a number of bytes, or all connections
 * at once.
 */
final class Cutter implements AutoCloseable {
    private final ServerSocket listening =
            new ServerSocket(0, 50, InetAddress.getLoopbackAddress());
    private final int server;
    private final Random random;
    private final int mostBytes;
    private final Set<Socket> open = ConcurrentHashMap.newKeySet();
    private final AtomicInteger cuts = new AtomicInteger();
    private volatile boolean passing = true;

    /**
     * @param mostBytes maximum number of bytes after which a connection is cut, 0 for never. The
     *     exact number is random.
     */
    Cutter(int server, long seed, int mostBytes) throws IOException {
        this.server = server;
        this.random = new Random(seed);
        this.mostBytes = mostBytes;
        Thread.ofVirtual().start(this::accept);
    }

    int port() {
        return listening.getLocalPort();
    }

    /** Returns the number of connections that were cut. */
    int cuts() {
        return cuts.get();
    }

    /** Cuts all present connections. */
    void cut() {
        open.forEach(Cutter::close);
    }

    /** Cuts all connections, and accepts no more. */
    void block() {
        passing = false;
        cut();
    }

    private void accept() {
        try {
            while (true) {
                Socket client = listening.accept();
                if (passing) {
                    join(client, new Socket(InetAddress.getLoopbackAddress(), server));
                } else {
                    reset(client);
                }
            }
        } catch (IOException closed) {
            cut();
        }
    }

    private void join(Socket client, Socket way) throws IOException {
        open.add(client);
        open.add(way);
        client.setTcpNoDelay(true);
        way.setTcpNoDelay(true);
        int left = mostBytes == 0 ? Integer.MAX_VALUE : random.nextInt(mostBytes / 4, mostBytes);
        Thread.ofVirtual().start(() -> relay(client, way, Integer.MAX_VALUE));
        Thread.ofVirtual().start(() -> relay(way, client, left));
    }

    private void relay(Socket from, Socket to, int most) {
        try (from;
                to) {
            InputStream in = from.getInputStream();
            OutputStream out = to.getOutputStream();
            byte[] bytes = new byte[4096];
            int left = most;
            for (int count = in.read(bytes); count >= 0; count = in.read(bytes)) {
                out.write(bytes, 0, Math.min(count, left));
                left -= count;
                if (left <= 0) {
                    cuts.incrementAndGet();
                    reset(to);
                    return;
                }
            }
        } catch (IOException cut) {
            // an expected failure: the relay cuts connections
        } finally {
            open.remove(from);
            open.remove(to);
        }
    }

    private static void reset(Socket socket) throws IOException {
        socket.setSoLinger(true, 0);
        socket.close();
    }

    private static void close(Socket socket) {
        try {
            socket.close();
        } catch (IOException e) {
            // it is closed in any case
        }
    }

    @Override
    public void close() throws IOException {
        listening.close();
        cut();
    }
}
