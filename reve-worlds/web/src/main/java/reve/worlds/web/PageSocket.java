// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.websocket.api.Callback;
import org.eclipse.jetty.websocket.api.Session;
import org.eclipse.jetty.websocket.api.StatusCode;
import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.agent.AgentServer;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SocketChannel;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.Map;

/**
 * One WebSocket of a page. A text message is one line of the agent protocol in either direction;
 * the session behind it decides about roles, tokens, rights and limits, as for a TCP connection.
 * Binary messages of the page control the view of the scene, see {@link Watcher}; they have no
 * effect unless the session's role perceives everything.
 */
public final class PageSocket implements Session.Listener.AutoDemanding {

    private static final Logger LOG = LoggerFactory.getLogger("reve.page");
    private static final JsonMapper JSON = new JsonMapper();
    private static final byte[] WELCOME = "{\"t\":\"welcome\"".getBytes(StandardCharsets.US_ASCII);
    private static final int FIRST_BYTES = 16 * 1024;

    private final AgentServer agents;
    private final Map<String, SceneFeed> feeds;
    private final InetSocketAddress peer;
    private @Nullable Session session;
    private @Nullable SocketChannel line;

    /** Set by the reader of lines after the welcome. */
    private volatile @Nullable Watcher watcher;

    PageSocket(AgentServer agents, Map<String, SceneFeed> feeds, InetSocketAddress peer) {
        this.agents = agents;
        this.feeds = feeds;
        this.peer = peer;
    }

    @Override
    public void onWebSocketOpen(Session opened) {
        session = opened;
        try {
            SocketChannel channel = agents.connect(peer);
            line = channel;
            Thread.ofVirtual().name("page " + peer).start(() -> relay(channel, opened));
        } catch (IOException e) {
            LOG.warn("a page could not be connected to the agent server: {}", e.getMessage());
            opened.close(StatusCode.SERVER_ERROR, "the server has no free sockets", Callback.NOOP);
        }
    }

    @Override
    public void onWebSocketText(String message) {
        SocketChannel channel = line;
        if (channel == null) {
            return;
        }
        try {
            ByteBuffer bytes = ByteBuffer.wrap((message + "\n").getBytes(StandardCharsets.UTF_8));
            while (bytes.hasRemaining()) {
                channel.write(bytes);
            }
        } catch (IOException ended) {
            // The reader of lines closes the WebSocket, after the last line was sent.
        }
    }

    @Override
    public void onWebSocketBinary(ByteBuffer message, Callback callback) {
        Watcher watching = watcher;
        if (watching != null) {
            watching.take(message);
        }
        callback.succeed();
    }

    @Override
    public void onWebSocketError(Throwable cause) {
        LOG.debug("the WebSocket of {} failed", peer, cause);
        end();
    }

    @Override
    public void onWebSocketClose(int status, String reason, Callback callback) {
        end();
        callback.succeed();
    }

    private void end() {
        Watcher watching = watcher;
        if (watching != null) {
            watching.close();
        }
        SocketChannel channel = line;
        if (channel != null) {
            try {
                channel.close();
            } catch (IOException e) {
                // Closing frees the descriptor even if it fails.
            }
        }
    }

    /** Sends the lines of the agent server to the page until its connection ends. */
    private void relay(SocketChannel channel, Session page) {
        byte[] bytes = new byte[FIRST_BYTES];
        int end = 0;
        try {
            while (true) {
                int start = 0;
                int count = channel.read(ByteBuffer.wrap(bytes, end, bytes.length - end));
                if (count < 0) {
                    break;
                }
                int searched = end;
                end += count;
                for (int at = searched; at < end; at++) {
                    if (bytes[at] == '\n') {
                        take(bytes, start, at, page);
                        start = at + 1;
                    }
                }
                System.arraycopy(bytes, start, bytes, 0, end - start);
                end -= start;
                if (end == bytes.length) {
                    bytes = Arrays.copyOf(bytes, 2 * bytes.length);
                } else if (end == 0 && bytes.length > FIRST_BYTES) {
                    bytes = new byte[FIRST_BYTES];
                }
            }
            page.close(StatusCode.NORMAL, "the session has ended", Callback.NOOP);
        } catch (IOException | RuntimeException ended) {
            LOG.debug("the connection of the page at {} has ended", peer, ended);
            page.disconnect();
        } finally {
            end();
        }
    }

    private void take(byte[] bytes, int start, int end, Session page) {
        if (watcher == null && startsWith(bytes, start, end, WELCOME)) {
            welcomed(JSON.readTree(bytes, start, end - start), page);
        }
        var sent = new Callback.Completable();
        page.sendText(new String(bytes, start, end - start, StandardCharsets.UTF_8), sent);
        sent.join(); // a page that does not read holds up its own lines only
    }

    private static boolean startsWith(byte[] bytes, int start, int end, byte[] prefix) {
        return end - start >= prefix.length
                && Arrays.equals(bytes, start, start + prefix.length, prefix, 0, prefix.length);
    }

    /** Permits the view of the scene if the role perceives everything. */
    private void welcomed(JsonNode welcome, Session page) {
        if (!welcome.path("role").asString("").equals("agent")) {
            String world = welcome.path("world").asString("");
            SceneFeed feed = feeds.get(world);
            if (feed != null) {
                String name = welcome.path("agent").asString("");
                watcher =
                        new Watcher(
                                feed,
                                page,
                                frame ->
                                        agents.record(
                                                world,
                                                name,
                                                "{\"t\":\"view\",\"frame\":" + frame + "}"));
            }
        }
    }
}
