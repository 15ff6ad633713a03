// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.net.URI;
import java.net.http.HttpClient;
import java.net.http.WebSocket;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.HashMap;
import java.util.Map;
import java.util.concurrent.BlockingQueue;
import java.util.concurrent.CompletionException;
import java.util.concurrent.CompletionStage;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
import java.util.function.Predicate;

/** A WebSocket client that sends the same messages as the page and draws nothing. */
final class PageClient implements WebSocket.Listener, AutoCloseable {

    static final JsonMapper JSON = new JsonMapper();
    private static final long PATIENCE_SECONDS = 60;

    private final HttpClient http = HttpClient.newHttpClient();
    final BlockingQueue<JsonNode> lines = new LinkedBlockingQueue<>();
    final BlockingQueue<ByteBuffer> frames = new LinkedBlockingQueue<>();
    private final StringBuilder text = new StringBuilder();
    private final ByteArrayOutputStream bytes = new ByteArrayOutputStream();
    private final WebSocket socket;
    private volatile boolean reads = true;
    volatile boolean closed;

    /** One frame of the scene. */
    record Frame(
            long frame,
            double time,
            JsonNode structure,
            Map<Integer, Map<Integer, float[]>> columns) {}

    /** Opens the WebSocket of a page at this address, like a page of that origin. */
    PageClient(String page, String origin) throws IOException {
        try {
            socket =
                    http.newWebSocketBuilder()
                            .header("Origin", origin)
                            .buildAsync(
                                    URI.create(page.replaceFirst("^http", "ws") + "world"), this)
                            .join();
        } catch (CompletionException refused) {
            http.close();
            throw new IOException("the WebSocket was refused", refused.getCause());
        }
    }

    PageClient(String page) throws IOException {
        this(page, page.substring(0, page.length() - 1));
    }

    /** Stops reading from the socket, like a page that hangs. */
    void hang() {
        reads = false;
    }

    void readAgain() {
        reads = true;
        socket.request(1);
    }

    @Override
    public CompletionStage<?> onText(WebSocket from, CharSequence part, boolean last) {
        text.append(part);
        if (last) {
            lines.add(JSON.readTree(text.toString()));
            text.setLength(0);
        }
        next();
        return null;
    }

    @Override
    public CompletionStage<?> onBinary(WebSocket from, ByteBuffer part, boolean last) {
        byte[] all = new byte[part.remaining()];
        part.get(all);
        bytes.writeBytes(all);
        if (last) {
            frames.add(ByteBuffer.wrap(bytes.toByteArray()).order(ByteOrder.LITTLE_ENDIAN));
            bytes.reset();
        }
        next();
        return null;
    }

    @Override
    public void onOpen(WebSocket opened) {
        opened.request(1);
    }

    @Override
    public CompletionStage<?> onClose(WebSocket from, int status, String reason) {
        closed = true;
        return null;
    }

    @Override
    public void onError(WebSocket from, Throwable error) {
        closed = true;
    }

    private void next() {
        if (reads) {
            socket.request(1);
        }
    }

    void say(String line) {
        socket.sendText(line, true).join();
    }

    /** Requests a frame of the scene. */
    void watch(int columns) {
        socket.sendBinary(ByteBuffer.wrap(new byte[] {(byte) columns}), true).join();
    }

    JsonNode await(Predicate<JsonNode> wanted) throws InterruptedException {
        long end = System.nanoTime() + TimeUnit.SECONDS.toNanos(PATIENCE_SECONDS);
        while (System.nanoTime() < end) {
            JsonNode line = lines.poll(1, TimeUnit.SECONDS);
            if (line != null && wanted.test(line)) {
                return line;
            }
        }
        throw new AssertionError("the line never came");
    }

    JsonNode await(String type) throws InterruptedException {
        return await(line -> line.path("t").asString("").equals(type));
    }

    JsonNode answer(long id) throws InterruptedException {
        return await(line -> line.path("id").asLong(-1) == id);
    }

    /** Says hello and waits for the welcome. */
    JsonNode join(String name, String role) throws InterruptedException {
        say("{\"t\":\"hello\",\"protocol\":1,\"name\":\"" + name + "\",\"role\":\"" + role + "\"}");
        return await("welcome");
    }

    Frame frame() throws InterruptedException {
        ByteBuffer message = frames.poll(PATIENCE_SECONDS, TimeUnit.SECONDS);
        if (message == null) {
            throw new AssertionError("the frame never came");
        }
        return read(message);
    }

    static Frame read(ByteBuffer message) {
        if (message.getInt() != SceneWriter.FRAME) {
            throw new AssertionError("this is no frame");
        }
        int structureBytes = message.getInt();
        int sections = message.getInt();
        message.getInt();
        long frame = (long) message.getDouble();
        double time = message.getDouble();
        byte[] structure = new byte[structureBytes];
        message.get(structure);
        message.position(message.position() + (-structureBytes & 3));
        Map<Integer, Map<Integer, float[]>> columns = new HashMap<>();
        for (int section = 0; section < sections; section++) {
            int column = message.getInt();
            int[] slots = new int[message.getInt()];
            for (int i = 0; i < slots.length; i++) {
                slots[i] = message.getInt();
            }
            Map<Integer, float[]> values = new HashMap<>();
            for (int slot : slots) {
                float[] value = new float[SceneColumns.values()[column].components()];
                for (int i = 0; i < value.length; i++) {
                    value[i] = message.getFloat();
                }
                values.put(slot, value);
            }
            columns.put(column, values);
        }
        return new Frame(
                frame,
                time,
                structureBytes == 0
                        ? JSON.createObjectNode()
                        : JSON.readTree(new String(structure, StandardCharsets.UTF_8)),
                columns);
    }

    @Override
    public void close() {
        socket.abort();
        http.shutdownNow();
    }
}
