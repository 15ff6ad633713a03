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
import java.time.Duration;
import java.util.Optional;

import javax.net.ssl.SSLContext;
import javax.net.ssl.SSLException;
import javax.net.ssl.SSLParameters;
import javax.net.ssl.SSLSocket;

/**
 * One connection to a server after its welcome. One thread may read; threads that write need a
 * lock.
 */
final class Wire implements Closeable {

    private final Socket socket;
    private final DataInputStream in;
    private final OutputStream out;

    private Wire(Socket socket) throws IOException {
        this.socket = socket;
        this.in = new DataInputStream(new BufferedInputStream(socket.getInputStream()));
        this.out = socket.getOutputStream();
    }

    /** A connection and its welcome. */
    record Opened(Wire wire, Welcome welcome) {}

    /**
     * Connects, does the TLS handshake if TLS is used, sends hello and waits for the welcome.
     *
     * @throws IOException if no server listens there, or the connection breaks before the welcome
     * @throws AgentException if the server refuses, or does not answer within the patience
     */
    static Opened open(InetSocketAddress address, Join join) throws IOException {
        var socket = new Socket();
        try {
            int patience = Math.toIntExact(join.patience().toMillis());
            connect(socket, address, patience);
            socket.setSoTimeout(patience);
            socket.setTcpNoDelay(true);
            var wire =
                    new Wire(
                            join.tls().isPresent()
                                    ? secure(socket, address.getHostString(), join.tls().get())
                                    : socket);
            wire.write(encode(Protocol.hello(join), Encoding.JSON));
            Welcome welcome = wire.awaitWelcome(join.patience());
            socket.setSoTimeout(0);
            return new Opened(wire, welcome);
        } catch (SSLException e) {
            socket.close();
            throw new DisconnectedException(
                    "tls-failed",
                    e.getMessage(),
                    Optional.of(
                            "does the server speak TLS, and is its certificate one that you"
                                    + " trust?"));
        } catch (IOException | RuntimeException e) {
            socket.close();
            throw e;
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
     * Waits for the welcome. Before the welcome, the server may only send pings, refuse the hello
     * or end the connection.
     */
    private Welcome awaitWelcome(Duration patience) throws IOException {
        try {
            while (true) {
                switch (next()) {
                    case Welcome welcome -> {
                        return welcome;
                    }
                    case ServerMessage.Ping ping -> write(encode(Protocol.pong(), Encoding.JSON));
                    case ServerMessage.Bye bye ->
                            throw new DisconnectedException(bye.code(), bye.message(), bye.hint());
                    case ServerMessage.Error error -> throw AgentException.refused(error);
                    case ServerMessage other -> throw AgentException.unexpected(other);
                }
            }
        } catch (SocketTimeoutException e) {
            throw AgentException.noAnswer(patience);
        }
    }

    /**
     * Returns the next message.
     *
     * @throws EOFException if the server has closed the connection
     */
    ServerMessage next() throws IOException {
        int first = in.read();
        if (first < 0) {
            throw new EOFException("the server closed it without a reason");
        }
        if (first != 0) { // a line of JSON begins with a brace, a length prefix with 0
            return Protocol.read(line(first));
        }
        byte[] packed = new byte[in.readUnsignedByte() << 16 | in.readUnsignedShort()];
        in.readFully(packed);
        return Protocol.read(packed);
    }

    private String line(int first) throws IOException {
        var line = new ByteArrayOutputStream(256);
        int next = first;
        for (; next >= 0 && next != '\n'; next = in.read()) {
            line.write(next);
        }
        if (next < 0) {
            throw new EOFException("the server closed it within a line");
        }
        return line.toString(StandardCharsets.UTF_8);
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
