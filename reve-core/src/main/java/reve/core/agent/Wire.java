package reve.core.agent;

import java.io.IOException;
import java.net.SocketAddress;
import java.net.StandardSocketOptions;
import java.nio.ByteBuffer;
import java.nio.channels.ByteChannel;
import java.nio.channels.SelectionKey;
import java.nio.channels.SocketChannel;

/** The bytes that go to and from one client; reading and writing never wait. The event loop's thread. */
interface Wire extends ByteChannel {

    /** Who is at the other end, for people to read. */
    SocketAddress peer() throws IOException;

    /** Tells the handler when there is something to read, and later whatever the key asks for. */
    SelectionKey register(EventLoop loop, EventLoop.Handler handler) throws IOException;

    /** Tells the client that nothing more will come. */
    void shutdownOutput() throws IOException;

    /** Plain TCP. */
    static Wire of(SocketChannel channel) {
        return new Plain(channel);
    }

    /** See {@link #of}. */
    record Plain(SocketChannel channel) implements Wire {

        private static final int SEND_BUFFER_BYTES = 64 * 1024;

        @Override
        public SocketAddress peer() throws IOException {
            return channel.getRemoteAddress();
        }

        @Override
        public SelectionKey register(EventLoop loop, EventLoop.Handler handler) throws IOException {
            channel.setOption(StandardSocketOptions.TCP_NODELAY, true);
            channel.setOption(StandardSocketOptions.SO_SNDBUF, SEND_BUFFER_BYTES);
            return loop.register(channel, SelectionKey.OP_READ, handler);
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
