// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.perception.Difference;
import reve.core.agent.perception.PerceptionEncoder;
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
 * Writer of the messages that wait in the outbox of a connection: encodes and writes them until the
 * socket accepts no more. Runs on the event loop's thread, or on another thread while the event
 * loop waits for it.
 */
final class ConnectionWriter {

    /**
     * Cost that is charged for each byte of a large perception in addition to the writing time
     * [ns/byte]. Large perceptions occupy memory until the client has read them.
     */
    private static final long NANOS_PER_LARGE_BYTE = 4;

    /**
     * Number of bytes that the socket must accept within the time limit of a write. If fewer bytes
     * are left, the socket must accept all of them.
     */
    private static final int PROGRESS_BYTES = 64 * 1024;

    private final Connections connections;
    private final Connection connection;
    private final Wire wire;
    private final SelectionKey key;
    private final Outbox outbox;

    /**
     * The data being written; the socket has accepted the first {@link #sent} bytes. Null if there
     * is none.
     */
    private @Nullable Rope unsent;

    private int sent;

    /**
     * Start of the current time limit [ns]. The limit restarts whenever the socket has accepted
     * {@link #PROGRESS_BYTES} more.
     */
    private long unsentSinceNanos;

    /** Value of {@link #sent} at the start of the current time limit. */
    private int progress;

    /** True if the data being written contains a perception. */
    private boolean perceives;

    /** True after the socket's send buffer was enlarged for large messages. */
    private boolean expectsMuch;

    private long perceivedBytes;

    /**
     * True if all data is written and the output is shut down. The server then waits until the
     * client closes the connection.
     */
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
     * Writes waiting messages. Shuts down the output after the last message if the connection has
     * ended.
     *
     * @param client the session; null before the hello
     * @throws CloseReason if nothing may be sent, because the audit record cannot be written
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

    /**
     * Writes a last message instead of the waiting ones, and shuts down the output. Called only
     * when no message is partly written.
     */
    void writeLast(byte[] message) throws IOException {
        wire.write(ByteBuffer.wrap(message));
        shut();
    }

    /** Returns whether the output is shut down. */
    boolean isShut() {
        return shut;
    }

    /**
     * Returns whether the socket has accepted less than 64 KiB of the waiting data for longer than
     * {@code nanos}.
     */
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
     * Encodes and writes waiting messages.
     *
     * @return true if no data is left to write
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
                try {
                    Objects.requireNonNull(client)
                            .encoder()
                            .write(
                                    out,
                                    difference,
                                    encoding,
                                    perception.id(),
                                    perception.view(),
                                    perception.before());
                } catch (PerceptionEncoder.TooLarge tooLarge) {
                    throw CloseReason.cut("too-large", tooLarge.getMessage());
                }
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
     * Continues to write the data of an earlier write.
     *
     * @return true if all this data is sent
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

    /** Writes the unsent data until the socket accepts no more. */
    private void writePieces(ByteBuffer piece) throws IOException {
        Rope rest = unsent;
        if (rest == null || sent == rest.size()) {
            wire.write(piece.clear().limit(0)); // flushes the buffer of the TLS layer
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

    /** Returns whether the socket has not accepted all data of the last write. */
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
