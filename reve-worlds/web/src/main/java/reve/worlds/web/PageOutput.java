// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.websocket.api.Callback;
import org.eclipse.jetty.websocket.api.Session;

import java.nio.ByteBuffer;
import java.util.List;
import java.util.concurrent.CompletionException;
import java.util.concurrent.locks.ReentrantLock;
import java.util.function.Consumer;

/**
 * The output to one web page. Lines of the agent protocol and frames of the scene take turns. Each
 * message is written in pieces, so only one piece at a time waits in memory. A page that accepts no
 * piece for some seconds is disconnected.
 */
final class PageOutput {

    /** Maximum size of a piece [bytes]. */
    static final int PIECE_BYTES = 16 * 1024;

    /**
     * Maximum time until the page accepts a piece [ns]. It is also the maximum time until the page
     * accepts the remaining messages after the session has ended.
     */
    static final long PATIENCE_NANOS = 5_000_000_000L;

    private static final long NEVER = Long.MAX_VALUE;

    private final Session page;
    private final OpenPages pages;

    /**
     * The lock that a thread holds while it writes a message. The lock is fair, so that lines and
     * frames take turns.
     */
    private final ReentrantLock turn = new ReentrantLock(true);

    /** Time by which the page must accept the present piece [ns since the start]. */
    private volatile long pieceDueNanos = NEVER;

    /** Time by which the connection must have ended [ns since the start]. */
    private volatile long endDueNanos = NEVER;

    private volatile boolean closed;

    PageOutput(Session page, OpenPages pages) {
        this.page = page;
        this.pages = pages;
        pages.add(this);
    }

    /**
     * Sends a part of a line, and returns when the page's socket has accepted it. For one thread.
     *
     * @param last true if the line ends with this part
     * @throws CompletionException if the connection ended first
     */
    void line(String piece, boolean last) {
        if (!turn.isHeldByCurrentThread()) {
            turn.lock();
        }
        send(sent -> page.sendPartialText(piece, last, sent));
        if (last) {
            turn.unlock();
        }
    }

    /**
     * Allows frames to be sent again after a line was interrupted. Called on the thread of {@link
     * #line}.
     */
    void abandonLine() {
        if (turn.isHeldByCurrentThread()) {
            turn.unlock();
        }
    }

    /**
     * Sends a frame of the scene on a separate thread.
     *
     * @param assets meshes and textures to send before the frame; the scene owns these messages
     * @param frame the frame, which is not modified; its memory counts as waiting until it is sent
     * @param sent called after the frame was sent, unless the connection ended first
     */
    void frame(List<ByteBuffer> assets, ByteBuffer frame, Runnable sent) {
        pages.hold(this, frame);
        Thread.ofVirtual()
                .name("page frame")
                .start(
                        () -> {
                            turn.lock();
                            try {
                                assets.forEach(this::binary);
                                binary(frame);
                            } catch (RuntimeException ended) {
                                cut();
                                return;
                            } finally {
                                turn.unlock();
                                pages.release(this);
                            }
                            sent.run();
                        });
    }

    private void binary(ByteBuffer message) {
        int size = message.limit();
        int from = 0;
        do {
            ByteBuffer piece = message.slice(from, Math.min(PIECE_BYTES, size - from));
            from += piece.limit();
            boolean last = from == size;
            send(sent -> page.sendPartialBinary(piece, last, sent));
        } while (from < size);
    }

    private void send(Consumer<Callback> piece) {
        var sent = new Callback.Completable();
        pieceDueNanos = pages.nowNanos() + PATIENCE_NANOS;
        if (closed) {
            throw new CompletionException("the page was disconnected", null);
        }
        piece.accept(sent);
        sent.join();
        pieceDueNanos = NEVER;
    }

    /** Starts the time limit for the messages that still wait. For any thread. */
    void endSoon() {
        if (endDueNanos == NEVER) {
            endDueNanos = pages.nowNanos() + PATIENCE_NANOS;
        }
    }

    /** Closes the WebSocket after the messages sent so far. For any thread. */
    void end(int status, String reason) {
        endSoon();
        page.close(status, reason, Callback.NOOP);
    }

    /** Disconnects the page if it is too slow. Called periodically. */
    void check(long nowNanos) {
        if (nowNanos > pieceDueNanos || nowNanos > endDueNanos) {
            cut();
        }
    }

    /** Disconnects the page at once. Waiting messages fail. For any thread. */
    void cut() {
        closed = true;
        page.disconnect();
    }

    /** Removes the page, because its connection has ended. For any thread. */
    void close() {
        closed = true;
        pages.remove(this);
    }
}
