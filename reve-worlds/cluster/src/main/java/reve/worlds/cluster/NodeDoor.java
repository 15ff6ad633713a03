// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import java.io.IOException;
import java.net.BindException;
import java.net.InetAddress;
import java.net.InetSocketAddress;
import java.net.StandardSocketOptions;
import java.nio.ByteBuffer;
import java.nio.channels.ServerSocketChannel;
import java.nio.channels.SocketChannel;
import java.util.HashSet;
import java.util.Iterator;
import java.util.LinkedHashSet;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;
import java.util.function.Predicate;

/**
 * The listener of a node for the other nodes. It limits the number of connections, which Pekko does
 * not: everyone who reaches the port may connect, and proves only afterwards, by a certificate,
 * that it is a node. It passes the bytes of a connection to Pekko's own listener on the loopback
 * interface, unchanged. For any thread.
 *
 * <p>When an address, or all addresses together, have too many connections, the oldest of those
 * that may still be unproven is closed. A node whose connection is closed connects again.
 */
final class NodeDoor implements AutoCloseable {
    /**
     * Number of received bytes from which a connection counts as one of a node. A client without a
     * certificate cannot send as many, because TLS ends handshakes that are longer than 32 KiB.
     */
    static final long PROVEN_BYTES = 65_536;

    private static final int FEWEST = 16;
    private static final int MOST = 256;

    /** Share of the process's file descriptors per connection, each of which needs two. */
    private static final int DESCRIPTORS_PER_CONNECTION = 32;

    private static final int BUFFER_BYTES = 16_384;
    private static final long PAUSE_NANOSECONDS = 100_000_000;
    private static final long REPORT_NANOSECONDS = 60_000_000_000L;

    private final ServerSocketChannel listener;
    private final InetSocketAddress inside;
    private final int most;
    private final Consumer<String> problems;

    /** The connections in the order in which they were accepted. Guarded by itself. */
    private final Set<Connection> connections = new LinkedHashSet<>();

    private long closedForRoom;
    private long reportedNanos = System.nanoTime() - REPORT_NANOSECONDS;

    /**
     * Listens, but accepts nothing before {@link #open}.
     *
     * @param listen address for other nodes; port 0 for any free one
     * @param inside address of Pekko's listener
     * @param most maximum number of connections
     * @param problems is told, at most once a minute, that connections were closed
     * @throws BindException if the address cannot be bound
     */
    NodeDoor(NodeAddress listen, InetSocketAddress inside, int most, Consumer<String> problems)
            throws IOException {
        this.inside = inside;
        this.most = most;
        this.problems = problems;
        listener = ServerSocketChannel.open();
        try {
            listener.bind(new InetSocketAddress(listen.host(), listen.port()));
        } catch (IOException | RuntimeException refused) {
            listener.close();
            throw refused;
        }
    }

    /** Returns the maximum number of connections for a process with so many file descriptors. */
    static int most(long descriptors) {
        return Math.clamp(descriptors / DESCRIPTORS_PER_CONNECTION, FEWEST, MOST);
    }

    /** Returns the port of the listener. */
    int port() {
        return listener.socket().getLocalPort();
    }

    /** Accepts connections from now on. */
    void open() {
        Thread.ofPlatform().name("door for nodes").daemon().start(this::accept);
    }

    private void accept() {
        while (listener.isOpen()) {
            try {
                receive(listener.accept());
            } catch (IOException noDescriptors) { // or the listener was closed
                LockSupport.parkNanos(PAUSE_NANOSECONDS);
            }
        }
    }

    private void receive(SocketChannel outside) throws IOException {
        Connection connection;
        try {
            connection = new Connection(outside);
        } catch (IOException noDescriptors) {
            outside.close();
            throw noDescriptors;
        }
        if (admit(connection)) {
            Thread.ofVirtual().name("connection of a node").start(connection::pass);
        } else {
            connection.close();
        }
    }

    /** Returns whether there is room for a connection, after closing another one if needed. */
    private boolean admit(Connection connection) {
        Optional<Connection> victim = Optional.empty();
        boolean isAdmitted = true;
        Optional<String> report = Optional.empty();
        synchronized (connections) {
            long ofAddress =
                    connections.stream().filter(each -> each.from.equals(connection.from)).count();
            if (ofAddress >= most / 2 || connections.size() >= most) {
                victim =
                        oldestUnproven(
                                each -> ofAddress < most / 2 || each.from.equals(connection.from));
                victim.ifPresent(connections::remove);
                isAdmitted = victim.isPresent();
                closedForRoom++;
                report = dueReport(connection.from, ofAddress);
            }
            if (isAdmitted) {
                connections.add(connection);
            }
        }
        victim.ifPresent(Connection::close);
        report.ifPresent(problems);
        return isAdmitted;
    }

    private Optional<Connection> oldestUnproven(Predicate<Connection> which) {
        Iterator<Connection> all = connections.iterator();
        while (all.hasNext()) {
            Connection each = all.next();
            if (which.test(each) && each.received < PROVEN_BYTES) {
                return Optional.of(each);
            }
        }
        return Optional.empty();
    }

    private Optional<String> dueReport(InetAddress from, long ofAddress) {
        long now = System.nanoTime();
        if (now - reportedNanos < REPORT_NANOSECONDS) {
            return Optional.empty();
        }
        reportedNanos = now;
        long closed = closedForRoom;
        closedForRoom = 0;
        return Optional.of(
                "the port for nodes has "
                        + connections.size()
                        + " connections, of which "
                        + ofAddress
                        + " come from "
                        + from.getHostAddress()
                        + ", expected at most "
                        + most
                        + " and "
                        + most / 2
                        + " from one address; "
                        + closed
                        + " were closed. Let only nodes reach this port");
    }

    @Override
    public void close() throws IOException {
        listener.close();
        Set<Connection> open;
        synchronized (connections) {
            open = new HashSet<>(connections);
            connections.clear();
        }
        open.forEach(Connection::close);
    }

    /**
     * A connection of another program, and the connection to Pekko's listener that belongs to it.
     */
    private final class Connection {
        private final SocketChannel outside;
        private final InetAddress from;
        private final SocketChannel toPekko;
        private volatile long received;

        Connection(SocketChannel outside) throws IOException {
            this.outside = outside;
            this.from = ((InetSocketAddress) outside.getRemoteAddress()).getAddress();
            this.toPekko = SocketChannel.open();
        }

        /** Passes bytes in both directions until one end closes the connection. */
        void pass() {
            try {
                outside.setOption(StandardSocketOptions.TCP_NODELAY, true);
                toPekko.setOption(StandardSocketOptions.TCP_NODELAY, true);
                toPekko.connect(inside);
                Thread.ofVirtual().name("answers to a node").start(this::answer);
                copy(outside, toPekko, true);
            } catch (IOException ended) {
                // Either end has closed the connection. A node connects again.
            } finally {
                close();
            }
        }

        private void answer() {
            try {
                copy(toPekko, outside, false);
            } catch (IOException ended) {
                // See pass().
            } finally {
                close();
            }
        }

        private void copy(SocketChannel source, SocketChannel target, boolean counts)
                throws IOException {
            ByteBuffer buffer = ByteBuffer.allocateDirect(BUFFER_BYTES);
            while (source.read(buffer) >= 0) {
                buffer.flip();
                if (counts) {
                    received += buffer.remaining();
                }
                while (buffer.hasRemaining()) {
                    target.write(buffer);
                }
                buffer.clear();
            }
        }

        void close() {
            synchronized (connections) {
                connections.remove(this);
            }
            for (SocketChannel channel : new SocketChannel[] {outside, toPekko}) {
                try {
                    channel.close();
                } catch (IOException closed) {
                    // The exception is ignored: the connection is not used any more.
                }
            }
        }
    }
}
