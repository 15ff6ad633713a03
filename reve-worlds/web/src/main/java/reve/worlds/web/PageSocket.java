// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.websocket.api.Callback;
import org.eclipse.jetty.websocket.api.Session;
import org.eclipse.jetty.websocket.api.StatusCode;
import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.agent.AgentServer;
import reve.core.agent.protocol.Relay;
import reve.core.agent.protocol.Role;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.ReadableByteChannel;
import java.nio.channels.SocketChannel;
import java.nio.charset.StandardCharsets;
import java.util.Map;

/**
 * One WebSocket of a web page. A text message is one line of the agent protocol in either
 * direction. A session of the agent server handles these lines. It decides about roles, tokens,
 * rights and limits, as for a TCP connection. Binary messages from the page request frames of the
 * scene, see {@link Watcher}. They have an effect only if the session's role perceives everything.
 */
public final class PageSocket implements Session.Listener.AutoDemanding, Relay {

    private static final Logger LOG = LoggerFactory.getLogger("reve.page");

    private final AgentServer agents;
    private final Map<String, SceneFeed> feeds;
    private final InetSocketAddress peer;
    private final OpenPages pages;
    private final ReadBudget budget;
    private volatile @Nullable Session session;
    private volatile @Nullable PageOutput output;
    private volatile @Nullable SocketChannel line;

    /**
     * The view of the scene; null until the client is welcomed. Written only while this object's
     * lock is held.
     */
    private volatile @Nullable Watcher watcher;

    /** True after the session has ended. Guarded by this object's lock. */
    private boolean ended;

    PageSocket(
            AgentServer agents,
            Map<String, SceneFeed> feeds,
            InetSocketAddress peer,
            OpenPages pages,
            ReadBudget budget) {
        this.budget = budget;
        this.agents = agents;
        this.feeds = feeds;
        this.peer = peer;
        this.pages = pages;
    }

    @Override
    public void onWebSocketOpen(Session opened) {
        var page = new PageOutput(opened, pages);
        output = page;
        session = opened;
        try {
            SocketChannel channel = agents.connect(peer, this);
            line = channel;
            Thread.ofVirtual()
                    .name("page " + peer)
                    .start(
                            () -> {
                                relay(channel, page);
                                end();
                            });
        } catch (IOException e) {
            // The server's log contains the reason.
            page.end(StatusCode.SERVER_ERROR, "the server has no free sockets");
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
            // The exception is ignored. The thread that relays lines closes the WebSocket after it
            // has sent the last line.
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

    /**
     * Answers a ping. Browsers send no pings, so only other clients do. A client that sends many
     * pings must wait.
     */
    @Override
    public void onWebSocketPing(ByteBuffer payload) {
        budget.spend(ReadBudget.REQUEST_BYTES);
        Session opened = session;
        if (opened != null) {
            byte[] bytes = new byte[payload.remaining()]; // the buffer is reused after this call
            payload.get(bytes);
            opened.sendPong(ByteBuffer.wrap(bytes), Callback.NOOP);
        }
    }

    @Override
    public void onWebSocketError(Throwable cause) {
        LOG.debug("the WebSocket of {} failed", peer, cause);
        close();
    }

    @Override
    public void onWebSocketClose(int status, String reason, Callback callback) {
        close();
        callback.succeed();
    }

    private void close() {
        end();
        PageOutput page = output;
        if (page != null) {
            page.close();
        }
    }

    private void end() {
        ended();
        SocketChannel channel = line;
        if (channel != null) {
            try {
                channel.close();
            } catch (IOException e) {
                // The exception is ignored, because the operating system frees the file descriptor
                // even if close() fails.
            }
        }
    }

    /**
     * Sends the lines of the agent server to the page until the page's connection ends. A long line
     * is sent in pieces. The connection to the agent server fills up if a page does not read. The
     * agent server's limits for slow clients then apply.
     */
    static void relay(ReadableByteChannel channel, PageOutput page) {
        byte[] bytes = new byte[PageOutput.PIECE_BYTES];
        int end = 0;
        try {
            while (true) {
                int count = channel.read(ByteBuffer.wrap(bytes, end, bytes.length - end));
                if (count < 0) {
                    break;
                }
                int start = 0;
                int searched = end;
                end += count;
                for (int at = searched; at < end; at++) {
                    if (bytes[at] == '\n') {
                        page.line(text(bytes, start, at), true);
                        start = at + 1;
                    }
                }
                if (start == 0 && end == bytes.length) {
                    start = lastCharacter(bytes, end);
                    page.line(text(bytes, 0, start), false);
                }
                System.arraycopy(bytes, start, bytes, 0, end - start);
                end -= start;
            }
            page.end(StatusCode.NORMAL, "the session has ended");
        } catch (IOException | RuntimeException ended) {
            LOG.debug("the connection of a page has ended", ended);
            page.cut();
        } finally {
            page.abandonLine();
        }
    }

    private static String text(byte[] bytes, int start, int end) {
        return new String(bytes, start, end - start, StandardCharsets.UTF_8);
    }

    /**
     * Returns the position of the last UTF-8 character in the bytes. This character may be
     * incomplete.
     */
    private static int lastCharacter(byte[] bytes, int end) {
        int at = end - 1;
        while (at > 0 && (bytes[at] & 0xc0) == 0x80) {
            at--;
        }
        return at;
    }

    /** Permits the page to request the scene if its role perceives everything. */
    @Override
    public synchronized void welcomed(Role role, String world, String name) {
        SceneFeed feed = feeds.get(world);
        PageOutput page = output;
        if (role != Role.AGENT && feed != null && page != null && !ended) {
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

    /** Ends the view of the scene, and starts the time limit for the lines that still wait. */
    @Override
    public synchronized void ended() {
        ended = true;
        Watcher watching = watcher;
        if (watching != null) {
            watching.close();
        }
        PageOutput page = output;
        if (page != null) {
            page.endSoon();
        }
    }
}
