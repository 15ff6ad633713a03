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
 * The non-blocking byte stream of one client, with or without TLS. For the event loop's thread
 * only.
 */
interface Wire extends ByteChannel {

    /** Returns the address of the peer. */
    InetSocketAddress peer() throws IOException;

    /**
     * Registers the handler for input. The caller may later change the operations of the returned
     * key.
     *
     * @param readable called when the stream has buffered input, which the key does not report
     */
    SelectionKey register(EventLoop loop, EventLoop.Handler handler, Runnable readable)
            throws IOException;

    /** Prepares for large messages: enlarges the send buffer. */
    default void expectMuch() throws IOException {}

    /**
     * Returns whether the stream has buffered input. The selection key does not report such input.
     */
    default boolean hasReceived() {
        return false;
    }

    /** Returns whether buffered output needs another {@link #write} to reach the socket. */
    default boolean hasUnsent() {
        return false;
    }

    /** Signals the end of the output to the client. */
    void shutdownOutput() throws IOException;

    /** Returns the stream of a connection without TLS. */
    static Wire of(SocketChannel channel, InetSocketAddress peer) {
        return new Plain(channel, peer);
    }

    /** The stream of a connection without TLS, see {@link #of}. */
    record Plain(SocketChannel channel, InetSocketAddress peer) implements Wire {

        /**
         * Send buffer of the socket [bytes]. A larger buffer adds latency and delays the detection
         * of slow readers.
         */
        private static final int SEND_BUFFER_BYTES = 32 * 1024;

        /**
         * Send buffer for clients that receive large messages [bytes]. A TCP segment on the
         * loopback interface has 64 KiB. The operating system waits 40 ms for each acknowledgement
         * if the buffer has room for only one segment.
         */
        private static final int LARGE_SEND_BUFFER_BYTES = 256 * 1024;

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
