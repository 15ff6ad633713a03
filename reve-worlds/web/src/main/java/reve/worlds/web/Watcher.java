// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.websocket.api.StatusCode;

import java.nio.ByteBuffer;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.Set;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.function.LongPredicate;

/**
 * A client that watches the scene of a world. Each request is answered by one frame, which is the
 * newest frame when it is sent. Therefore a slow client receives fewer frames, and at most one
 * frame waits for it.
 */
final class Watcher {

    /** Size of a request: one byte with the bits of the requested columns. */
    static final int MAX_REQUEST_BYTES = 1;

    private static final int STOP = 0xff;

    private final SceneFeed feed;
    private final PageOutput output;
    private final LongPredicate record;

    /** Requested columns as in {@link SceneColumns}. Negative if no frame is requested. */
    private final AtomicInteger request = new AtomicInteger(-1);

    /** True if the client requests the contacts of bodies with each frame. */
    private volatile boolean listening;

    private volatile boolean sending;
    private volatile boolean closed;

    // The fields below are for the encoder's thread only.

    /** Version of the scene that the client has received; 0 before the first frame. */
    private int version;

    /** Optional columns that the client has received since that version. */
    private int columns;

    private long sentNanos;
    private final Set<Integer> sent = new HashSet<>();

    /**
     * @param record writes the audit record before the first frame; returns false if the write
     *     failed, and nothing may be sent then
     */
    Watcher(SceneFeed feed, PageOutput output, LongPredicate record) {
        this.feed = feed;
        this.output = output;
        this.record = record;
    }

    /** Handles a request of the client. For any thread. */
    void take(ByteBuffer message) {
        if (message.remaining() != 1) {
            return;
        }
        int wanted = Byte.toUnsignedInt(message.get(message.position()));
        if (wanted == STOP) {
            listening = false;
            request.set(-1);
        } else {
            listening = (wanted & SceneColumns.CONTACTS_BIT) != 0;
            request.set(wanted & SceneColumns.ALL_OPTIONAL);
            feed.add(this);
        }
    }

    /** Ends the view of the scene. For any thread. */
    void close() {
        closed = true;
        feed.remove(this);
    }

    // ---- methods for the encoder's thread ----

    /** Returns whether the client waits for a frame that is newer than its last one. */
    boolean isReady(int current) {
        return !closed
                && !sending
                && request.get() >= 0
                && (version < current || (request.get() & ~columns) != 0);
    }

    /** Returns whether the client has requested a frame that the server has not begun to send. */
    boolean isWaiting() {
        return !closed && !sending && request.get() >= 0;
    }

    /** Returns the optional columns that the client has requested. */
    int wanted() {
        return Math.max(0, request.get());
    }

    /** Returns whether the client must learn of the contacts of every frame of the world. */
    boolean isListening() {
        return listening && !closed;
    }

    /** Returns the time of the last frame [ns]. */
    long sentNanos() {
        return sentNanos;
    }

    /** Sends the present state of the scene. */
    void send(Scene scene, SceneWriter writer, long nowNanos) {
        int wanted = request.getAndSet(-1);
        if (wanted < 0) {
            return;
        }
        if (version == 0 && !record.test(scene.frame())) {
            output.end(StatusCode.SERVER_ERROR, "the server cannot write its audit record");
            close();
            return;
        }
        var assets = new ArrayList<ByteBuffer>();
        for (int id : scene.assets()) {
            if (sent.add(id)) {
                assets.add(scene.asset(id));
            }
        }
        if (sent.size() > scene.assets().size()) {
            sent.retainAll(scene.assets());
        }
        ByteBuffer frame = writer.write(scene, version, columns, wanted);
        version = scene.version();
        columns = wanted;
        sentNanos = nowNanos;
        sending = true;
        output.frame(assets, frame, this::sent);
    }

    private void sent() {
        sending = false;
        feed.wake();
    }
}
