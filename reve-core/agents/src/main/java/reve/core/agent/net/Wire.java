// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.StandardSocketOptions;
import java.nio.ByteBuffer;
import java.nio.channels.ByteChannel;
import java.nio.channels.SelectionKey;
import java.nio.channels.SocketChannel;

/**
 * The bytes that go to and from one client; reading and writing never wait. The event loop's
 * thread.
 */
interface Wire extends ByteChannel {

    /** Who is at the other end. */
    InetSocketAddress peer() throws IOException;

    /**
     * Tells the handler when there is something to read, and later whatever the key asks for.
     *
     * @param readable called when there is something to read that the key says nothing of
     */
    SelectionKey register(EventLoop loop, EventLoop.Handler handler, Runnable readable)
            throws IOException;

    /** The client is sent much at a time. */
    default void expectMuch() throws IOException {}

    /** True if there is something to read that the key says nothing of. */
    default boolean hasReceived() {
        return false;
    }

    /**
     * True if something that was written is still to go to the socket, by another {@link #write}.
     */
    default boolean hasUnsent() {
        return false;
    }

    /** Tells the client that nothing more will come. */
    void shutdownOutput() throws IOException;

    /** Plain TCP. */
    static Wire of(SocketChannel channel) {
        return new Plain(channel);
    }

    /** See {@link #of}. */
    record Plain(SocketChannel channel) implements Wire {

        /** What fills it is latency, and how long it takes to find out who does not read. */
        private static final int SEND_BUFFER_BYTES = 32 * 1024;

        /**
         * Of those that are sent more at a time. On loopback a segment has 64 KiB; with room for
         * one only, the system waits 40 ms for each to be acknowledged.
         */
        private static final int LARGE_SEND_BUFFER_BYTES = 256 * 1024;

        @Override
        public InetSocketAddress peer() throws IOException {
            return (InetSocketAddress) channel.getRemoteAddress();
        }

        @Override
        public SelectionKey register(EventLoop loop, EventLoop.Handler handler, Runnable readable)
                throws IOException {
            channel.setOption(StandardSocketOptions.TCP_NODELAY, true);
            channel.setOption(StandardSocketOptions.SO_SNDBUF, SEND_BUFFER_BYTES);
            return loop.register(channel, SelectionKey.OP_READ, handler);
        }

        @Override
        public void expectMuch() throws IOException {
            channel.setOption(StandardSocketOptions.SO_SNDBUF, LARGE_SEND_BUFFER_BYTES);
        }

        @Override
        public int read(ByteBuffer bytes) throws IOException {
            return channel.read(bytes);
        }

        @Override
        public int write(ByteBuffer bytes) throws IOException {
            return channel.write(bytes);
        }

        @Override
        public void shutdownOutput() throws IOException {
            channel.shutdownOutput();
        }

        @Override
        public boolean isOpen() {
            return channel.isOpen();
        }

        @Override
        public void close() throws IOException {
            channel.close();
        }
    }
}
