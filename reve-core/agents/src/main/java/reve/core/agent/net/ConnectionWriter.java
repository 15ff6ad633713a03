// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.perception.Difference;
import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Rope;
import reve.core.agent.protocol.ServerMessage;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.util.Objects;
import java.util.OptionalLong;

/**
 * Encodes and writes what waits in the outbox of a connection, as far as its socket takes it. The
 * event loop's thread, or another one while the event loop waits for it.
 */
final class ConnectionWriter {

    /** What large perceptions cost besides the time to write them: memory, until they are read. */
    private static final long NANOS_PER_LARGE_BYTE = 4;

    /** So much of a write has to go in the time that one may take. */
    private static final int PROGRESS_BYTES = 64 * 1024;

    private final Connections connections;
    private final Connection connection;
    private final Wire wire;
    private final SelectionKey key;
    private final Outbox outbox;

    /** What is being written, of which {@link #sent} bytes have gone; null if nothing is. */
    private @Nullable Rope unsent;

    private int sent;

    /** Since when no more than {@link #PROGRESS_BYTES} of it have gone. */
    private long unsentSinceNanos;

    /** What of it had gone then. */
    private int progress;

    /** What is written holds a perception. */
    private boolean perceives;

    /** Its socket has room for much at a time. */
    private boolean expectsMuch;

    private long perceivedBytes;

    /** All is written; the client closes next. */
    private boolean shut;

    ConnectionWriter(
            Connections connections,
            Connection connection,
            Wire wire,
            SelectionKey key,
            Outbox outbox) {
        this.connections = connections;
        this.connection = connection;
        this.wire = wire;
        this.key = key;
        this.outbox = outbox;
    }

    /**
     * Writes what waits; after the last message, tells the client that nothing more will come.
     *
     * @param client null before its hello
     * @throws CloseReason if the client may be sent nothing
     */
    void write(WriteBuffers buffers, Encoding encoding, @Nullable Client client)
            throws IOException, CloseReason {
        if (wire.isOpen() && !shut) {
            if (!writeAll(buffers, encoding, client)) {
                connections.slowReaders().count(connection, outbox.bytes());
            } else if (outbox.isDone()) {
                shut();
            }
        }
    }

    /** Writes a message in place of all that waits. The connection is not stuck. */
    void writeLast(byte[] message) throws IOException {
        wire.write(ByteBuffer.wrap(message));
        shut();
    }

    /** Returns true if the last message is written. */
    boolean isShut() {
        return shut;
    }

    /** Returns true if the socket has taken less than 64 KiB for longer than that. */
    boolean isStuckFor(long nanos, long nowNanos) {
        return isStuck() && nowNanos - unsentSinceNanos > nanos;
    }

    private boolean writeAll(WriteBuffers buffers, Encoding encoding, @Nullable Client client)
            throws IOException, CloseReason {
        long begin = System.nanoTime();
        perceives = false;
        perceivedBytes = 0;
        try {
            return writeWaiting(buffers, encoding, client);
        } finally {
            if (perceives && client != null) {
                client.wrotePerception(
                        System.nanoTime()
                                - begin
                                + NANOS_PER_LARGE_BYTE
                                        * Math.max(0, perceivedBytes - WriteBuffers.BUFFER_BYTES));
            }
        }
    }

    /**
     * @return true if nothing is left to be written
     */
    private boolean writeWaiting(WriteBuffers buffers, Encoding encoding, @Nullable Client client)
            throws IOException, CloseReason {
        while (writeUnsent(buffers.buffer())) {
            Bytes out = buffers.bytes();
            Outbox.Waiting next = outbox.poll();
            while (next != null) {
                append(next, out, buffers.difference(), encoding, client);
                next = out.size() < WriteBuffers.BUFFER_BYTES ? outbox.poll() : null;
            }
            if (out.size() == 0) {
                return true;
            }
            send(out, buffers.buffer());
        }
        return false;
    }

    private void append(
            Outbox.Waiting next,
            Bytes out,
            Difference difference,
            Encoding encoding,
            @Nullable Client client)
            throws CloseReason {
        int start = out.size();
        switch (next) {
            case Outbox.Message message -> out.put(message.bytes());
            case Outbox.Missed missed ->
                    out.put(
                            ServerMessage.Event.missed(
                                            OptionalLong.of(missed.events()),
                                            missed.first(),
                                            missed.last())
                                    .in(encoding));
            case Outbox.Perception perception -> {
                perceives = true;
                int from = out.size();
                Objects.requireNonNull(client)
                        .encoder()
                        .write(
                                out,
                                difference,
                                encoding,
                                perception.id(),
                                perception.view(),
                                perception.before());
                perceivedBytes += out.size() - from;
            }
        }
        if (client != null
                && connections.audit().isPresent()
                && !connections
                        .audit()
                        .get()
                        .told(client.worldName(), client.name(), encoding, out.view(start))) {
            throw CloseReason.notRecorded();
        }
    }

    private void send(Bytes out, ByteBuffer piece) throws IOException {
        if (out.hasStrands()) {
            begin(out.rope(0));
            writePieces(piece);
        } else {
            for (int from = 0; from < out.size() && !isStuck(); ) {
                out.get(from, piece.clear());
                wire.write(piece.flip());
                from += piece.position();
                if (piece.hasRemaining() || wire.hasUnsent()) {
                    begin(out.rope(from));
                }
            }
        }
        if (unsent != null) {
            if (!expectsMuch && unsent.size() - sent > WriteBuffers.BUFFER_BYTES) {
                expectsMuch = true;
                wire.expectMuch();
            }
            connections.slowReaders().hold(connection, unsent);
        }
    }

    private void begin(Rope rest) {
        unsent = rest;
        sent = 0;
        progress = 0;
        unsentSinceNanos = System.nanoTime();
    }

    /**
     * @return true if nothing is left of what was to be written
     */
    private boolean writeUnsent(ByteBuffer piece) throws IOException {
        if (isStuck()) {
            writePieces(piece);
            if (sent - progress >= PROGRESS_BYTES) {
                progress = sent;
                unsentSinceNanos = System.nanoTime();
            }
            if (isStuck()) {
                key.interestOpsOr(SelectionKey.OP_WRITE);
                return false;
            }
            connections.slowReaders().release(connection);
            key.interestOpsAnd(~SelectionKey.OP_WRITE);
        }
        return true;
    }

    /** Writes what is unsent, as far as the socket takes it. */
    private void writePieces(ByteBuffer piece) throws IOException {
        Rope rest = unsent;
        if (rest == null || sent == rest.size()) {
            wire.write(piece.clear().limit(0)); // what the wire itself has kept
        }
        boolean isTaken = true;
        while (rest != null && sent < rest.size() && isTaken) {
            rest.get(sent, piece.clear());
            wire.write(piece.flip());
            sent += piece.position();
            isTaken = !piece.hasRemaining() && !wire.hasUnsent();
        }
        if (rest != null && sent == rest.size()) {
            unsent = null;
        }
    }

    /** Returns true if something was given to the socket that it has not taken. */
    boolean isStuck() {
        return unsent != null || wire.hasUnsent();
    }

    private void shut() throws IOException {
        if (!shut) {
            shut = true;
            wire.shutdownOutput();
            key.interestOpsOr(SelectionKey.OP_READ);
        }
    }
}
