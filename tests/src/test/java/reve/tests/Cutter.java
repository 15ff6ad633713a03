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
 * A way to a server of this machine that breaks: every connection after some bytes, or all of them
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
     * @param mostBytes after which a connection is cut, 0 for never; how many exactly is up to
     *     chance
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

    /** How many connections were cut. */
    int cuts() {
        return cuts.get();
    }

    /** Cuts all connections that there are. */
    void cut() {
        open.forEach(Cutter::close);
    }

    /** Cuts all connections, and lets nobody through from now on. */
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
            // That is what it is for.
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
            // It is closed, whatever it says.
        }
    }

    @Override
    public void close() throws IOException {
        listening.close();
        cut();
    }
}
