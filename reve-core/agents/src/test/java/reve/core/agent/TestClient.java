// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.BufferedReader;
import java.io.IOException;
import java.io.InputStreamReader;
import java.io.OutputStream;
import java.io.UncheckedIOException;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.net.SocketTimeoutException;
import java.nio.charset.StandardCharsets;
import java.util.ArrayDeque;
import java.util.Deque;

/** A client that sends and receives raw lines over a real socket. */
public final class TestClient implements AutoCloseable {

    private static final int PATIENCE_MILLIS = 300_000;
    private static final JsonMapper JSON = new JsonMapper();

    public final Socket socket;
    private final OutputStream out;
    private final BufferedReader in;
    private final Deque<JsonNode> early = new ArrayDeque<>();
    private int syncs;

    public TestClient(InetSocketAddress address) throws IOException {
        this(address, 0);
    }

    /**
     * @param receiveBytes size of the receive buffer, 0 for the system's
     */
    public TestClient(InetSocketAddress address, int receiveBytes) throws IOException {
        this(connected(address, receiveBytes));
    }

    /**
     * @param socket connected, and closed by the client
     */
    public TestClient(Socket socket) throws IOException {
        this.socket = socket;
        socket.setTcpNoDelay(true);
        socket.setSoTimeout(PATIENCE_MILLIS);
        out = socket.getOutputStream();
        in =
                new BufferedReader(
                        new InputStreamReader(socket.getInputStream(), StandardCharsets.UTF_8));
    }

    private static Socket connected(InetSocketAddress address, int receiveBytes)
            throws IOException {
        var socket = new Socket();
        if (receiveBytes > 0) {
            socket.setReceiveBufferSize(receiveBytes);
        }
        socket.connect(address);
        return socket;
    }

    public static JsonNode json(String text) {
        return JSON.readTree(text.replace('\'', '"'));
    }

    /** Sends a line. The character ' stands for ". */
    public TestClient say(String line) throws IOException {
        return send((line.replace('\'', '"') + "\n").getBytes(StandardCharsets.UTF_8));
    }

    TestClient send(byte[] bytes) throws IOException {
        out.write(bytes);
        out.flush();
        return this;
    }

    /** Returns when the server has processed everything sent so far. */
    public TestClient sync() throws IOException {
        int id = 1_000_000 + syncs++;
        say("{'t':'ping','id':" + id + "}");
        for (JsonNode message = read(); !isPong(message, id); message = read()) {
            early.addLast(message);
        }
        return this;
    }

    /** Returns whether unread data has arrived. */
    public boolean hasNews() {
        try {
            return !early.isEmpty() || in.ready();
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }

    /** Returns the next message, in the order sent. */
    public JsonNode next() throws IOException {
        return early.isEmpty() ? read() : early.removeFirst();
    }

    /** Returns the next message, which must have that type. */
    public JsonNode expect(String type) throws IOException {
        JsonNode message = next();
        assertThat(message.get("t").stringValue()).as("%s", message).isEqualTo(type);
        return message;
    }

    /**
     * Returns the next message, which must have that type and code; the caller checks its other
     * fields.
     */
    public JsonNode expect(String type, String code) throws IOException {
        JsonNode message = expect(type);
        assertThat(message.path("code").asString("")).as("%s", message).isEqualTo(code);
        return message;
    }

    /** Asserts that the connection ends with that reason. */
    public JsonNode expectBye(String code) throws IOException {
        JsonNode bye = expect("bye", code);
        assertThat(in.readLine()).as("after the bye").isNull();
        return bye;
    }

    /** Reads until the connection ends; the last message must be a bye with that code. */
    public void skipToBye(String code) throws IOException {
        JsonNode message = skipTo("bye");
        assertThat(message.get("code").stringValue()).as("%s", message).isEqualTo(code);
    }

    /** Reads up to the next message of that type. */
    public JsonNode skipTo(String type) throws IOException {
        JsonNode message = next();
        while (!message.get("t").stringValue().equals(type)) {
            message = next();
        }
        return message;
    }

    @Override
    public void close() throws IOException {
        socket.close();
    }

    private JsonNode read() throws IOException {
        try {
            String line = in.readLine();
            if (line == null) {
                throw new AssertionError("the server closed the connection; waiting: " + early);
            }
            return JSON.readTree(line);
        } catch (SocketTimeoutException e) {
            throw new AssertionError("the server is silent; waiting: " + early, e);
        }
    }

    private static boolean isPong(JsonNode message, int id) {
        return message.get("t").stringValue().equals("pong") && message.path("id").asInt(-1) == id;
    }
}
