// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import tools.jackson.databind.node.ObjectNode;

import java.io.BufferedInputStream;
import java.io.ByteArrayOutputStream;
import java.io.Closeable;
import java.io.DataInputStream;
import java.io.EOFException;
import java.io.IOException;
import java.io.OutputStream;
import java.net.ConnectException;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.net.SocketTimeoutException;
import java.nio.charset.StandardCharsets;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;

import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLException;
import javax.net.ssl.SSLParameters;
import javax.net.ssl.SSLSocket;

/**
 * One connection to a server after its welcome. One thread may read. Threads that write need a
 * lock.
 */
final class Wire implements Closeable {

    /** Maximum length of a message [bytes]. */
    private static final int MOST_BYTES = 1 << 30;

    /** Maximum length of the welcome and of the messages before it [bytes]. */
    private static final int MOST_BYTES_BEFORE_WELCOME = 1 << 20;

    private final Socket socket;
    private final Encoding encoding;
    private int mostBytes = MOST_BYTES_BEFORE_WELCOME;
    private final DataInputStream in;
    private final OutputStream out;

    private Wire(Socket socket, Encoding encoding) throws IOException {
        this.socket = socket;
        this.encoding = encoding;
        this.in = new DataInputStream(new BufferedInputStream(socket.getInputStream()));
        this.out = socket.getOutputStream();
    }

    /** Code of a failed TLS handshake; the exception has the cause. */
    static final String TLS_FAILED = "tls-failed";

    /** A connection and its welcome. */
    record Opened(Wire wire, Welcome welcome) {}

    /** A conversation after the first message. */
    private interface Talk<T> {
        T with(Wire wire) throws IOException;
    }

    /**
     * Connects, does the TLS handshake if TLS is used, sends hello and waits for the welcome.
     *
     * @throws IOException if no server listens there, or the connection breaks before the welcome
     * @throws AgentException if the server refuses, or does not answer within the patience
     */
    static Opened open(InetSocketAddress address, Join join) throws IOException {
        return begin(
                address,
                join,
                Protocol.hello(join),
                wire -> {
                    Welcome welcome = wire.await(Welcome.class);
                    wire.mostBytes = MOST_BYTES;
                    wire.socket.setSoTimeout(0);
                    return new Opened(wire, welcome);
                });
    }

    /**
     * Connects like {@link #open}, asks a question instead of joining a world, and disconnects.
     *
     * @param question the question of the hello
     */
    static ActResult ask(InetSocketAddress address, Join join, String question) throws IOException {
        return begin(
                address,
                join,
                Protocol.ask(join, question),
                wire -> {
                    try (wire) {
                        wire.mostBytes = MOST_BYTES;
                        return wire.await(ActResult.class);
                    }
                });
    }

    /** Connects, and sends the first message. */
    private static <T> T begin(InetSocketAddress address, Join join, ObjectNode first, Talk<T> talk)
            throws IOException {
        var socket = new Socket();
        var late = new AtomicBoolean();
        // A separate alarm limits the total time, because the timeout of the socket restarts with
        // each byte that the server sends.
        CompletableFuture<Void> alarm =
                CompletableFuture.runAsync(
                        () -> {
                            late.set(true);
                            closeQuietly(socket);
                        },
                        CompletableFuture.delayedExecutor(
                                join.patience().toMillis(), TimeUnit.MILLISECONDS));
        try {
            int patience = Math.toIntExact(join.patience().toMillis());
            connect(socket, address, patience);
            socket.setSoTimeout(patience);
            socket.setTcpNoDelay(true);
            var wire =
                    new Wire(
                            join.tls().isPresent()
                                    ? secure(socket, address.getHostString(), join.tls().get())
                                    : socket,
                            join.encoding());
            wire.write(encode(first, Encoding.JSON));
            return talk.with(wire);
        } catch (SSLException e) {
            socket.close();
            requireInTime(late, join);
            var failed =
                    new DisconnectedException(
                            TLS_FAILED,
                            e.getMessage(),
                            Optional.of(
                                    "does the server speak TLS, and is its certificate one that you"
                                            + " trust?"));
            failed.initCause(e);
            throw failed;
        } catch (SocketTimeoutException e) {
            socket.close();
            throw AgentException.noAnswer(join.patience());
        } catch (IOException | RuntimeException e) {
            socket.close();
            requireInTime(late, join);
            throw e;
        } finally {
            alarm.cancel(false);
        }
    }

    private static void requireInTime(AtomicBoolean late, Join join) {
        if (late.get()) {
            throw AgentException.noAnswer(join.patience());
        }
    }

    private static void closeQuietly(Socket socket) {
        try {
            socket.close();
        } catch (IOException e) {
            // The exception is ignored, because close() frees the descriptor even if it fails.
        }
    }

    private static void connect(Socket socket, InetSocketAddress address, int patienceMillis)
            throws IOException {
        try {
            socket.connect(resolved(address), patienceMillis);
        } catch (ConnectException e) {
            var named =
                    new ConnectException(
                            address.getHostString()
                                    + ":"
                                    + address.getPort()
                                    + ": "
                                    + e.getMessage()
                                    + "; does a server run there?");
            named.initCause(e);
            throw named;
        }
    }

    /** Resolves the host name again, because a restarted server may have another address. */
    private static InetSocketAddress resolved(InetSocketAddress address) {
        return new InetSocketAddress(address.getHostString(), address.getPort());
    }

    /** Does the TLS handshake, and checks that the certificate matches the host. */
    private static Socket secure(Socket socket, String host, SSLContext trusted)
            throws IOException {
        var secure =
                (SSLSocket)
                        trusted.getSocketFactory()
                                .createSocket(socket, host, socket.getPort(), true);
        SSLParameters parameters = secure.getSSLParameters();
        parameters.setEndpointIdentificationAlgorithm("HTTPS");
        secure.setSSLParameters(parameters);
        secure.startHandshake();
        return secure;
    }

    /**
     * Waits for the answer to the hello. The server may only send pings, refuse the hello or end
     * the connection before this answer.
     */
    private <T extends ServerMessage> T await(Class<T> type) throws IOException {
        while (true) {
            ServerMessage message = next();
            if (type.isInstance(message)) {
                return type.cast(message);
            }
            switch (message) {
                case ServerMessage.Ping ping -> write(encode(Protocol.pong(), Encoding.JSON));
                case ServerMessage.Bye bye -> throw DisconnectedException.of(bye);
                case ServerMessage.Error error -> throw AgentException.refused(error);
                case ServerMessage other -> throw AgentException.unexpected(other);
            }
        }
    }

    /**
     * Returns the next message.
     *
     * @throws EOFException if the server has closed the connection
     * @throws AgentException with code {@code protocol} if the data is no message, or the message
     *     is too long
     */
    ServerMessage next() throws IOException {
        int first = in.read();
        if (first < 0) {
            throw new EOFException("the server closed it without a reason");
        }
        if (encoding == Encoding.JSON || first == '{') {
            return Protocol.read(line(first));
        }
        int length = first << 24 | in.readUnsignedByte() << 16 | in.readUnsignedShort();
        require(length);
        byte[] packed = in.readNBytes(length); // the array grows with the bytes that arrive
        if (packed.length < length) {
            throw new EOFException("the server closed it within a message");
        }
        return Protocol.read(packed);
    }

    private String line(int first) throws IOException {
        var line = new ByteArrayOutputStream(256);
        int next = first;
        for (; next >= 0 && next != '\n'; next = in.read()) {
            line.write(next);
            require(line.size());
        }
        if (next < 0) {
            throw new EOFException("the server closed it within a line");
        }
        return line.toString(StandardCharsets.UTF_8);
    }

    private void require(int length) {
        if (length < 0 || length > mostBytes) {
            throw AgentException.tooLong(Integer.toUnsignedLong(length), mostBytes);
        }
    }

    void write(byte[] messages) throws IOException {
        out.write(messages);
        out.flush();
    }

    @Override
    public void close() throws IOException {
        socket.close();
    }

    static byte[] encode(ObjectNode message, Encoding encoding) {
        return encoding == Encoding.JSON
                ? (message + "\n").getBytes(StandardCharsets.UTF_8)
                : Packed.write(message);
    }
}
