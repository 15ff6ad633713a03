// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.channels.SocketChannel;
import java.util.Objects;
import java.util.concurrent.Executor;

import javax.net.ssl.SSLEngine;
import javax.net.ssl.SSLEngineResult;
import javax.net.ssl.SSLEngineResult.HandshakeStatus;
import javax.net.ssl.SSLException;

/**
 * The byte stream of a client over TLS. The expensive computations of a handshake run on another
 * thread.
 */
final class TlsWire implements Wire {

    /** First byte of a TLS connection; no message of the protocol begins with it. */
    static final int HANDSHAKE = 0x16;

    private static final ByteBuffer NOTHING = ByteBuffer.allocate(0);

    /**
     * Buffers for use within one call. Each thread has one set, because only few threads serve all
     * connections.
     */
    private static final ThreadLocal<Scratch> SCRATCH = ThreadLocal.withInitial(Scratch::new);

    /**
     * Size of a buffer for one TLS record [bytes]. A record has at most 16 KiB of data, and a
     * header.
     */
    private static final int RECORD_BYTES = 18 * 1024;

    /**
     * Maximum number of records without data after the handshake. Such a record may change the keys
     * ({@code KeyUpdate}), which costs far more computation than data. Clients change keys after
     * millions of records.
     */
    private static final int MOST_RECORDS_WITHOUT_DATA = 64;

    private final SocketChannel channel;
    private final Plain plain;
    private final SSLEngine engine;

    /** Runs the computations of handshakes. */
    private final Executor handshakes;

    // This field and the next one are null until {@link #register} sets them.
    private @Nullable EventLoop loop;
    private @Nullable SelectionKey key;
    private @Nullable Runnable readable;

    /**
     * Three buffers of this connection. The first contains received data that is incomplete, the
     * second decrypted data that is not read yet, the third encrypted data that is not sent yet.
     */
    private ByteBuffer incoming = NOTHING;

    private ByteBuffer received = NOTHING;
    private ByteBuffer outgoing = NOTHING;

    private boolean begun;
    private boolean shaken;

    /** Number of records without data that the client has sent after the handshake. */
    private int recordsWithoutData;

    private boolean computing;
    private boolean bypassed;

    /** Buffers for use within one call, shared by all connections. */
    private static final class Scratch {
        private final ByteBuffer incoming = ByteBuffer.allocate(2 * RECORD_BYTES);
        private final ByteBuffer received = ByteBuffer.allocate(2 * RECORD_BYTES);
        private final ByteBuffer outgoing = ByteBuffer.allocate(RECORD_BYTES);
    }

    /** Reports that the client does not use TLS. Further output is therefore plain text. */
    static final class PlainTextException extends IOException {
        private static final long serialVersionUID = 1;
    }

    /**
     * @param handshakes runs the computations of handshakes on platform threads
     */
    TlsWire(SocketChannel channel, InetSocketAddress peer, SSLEngine engine, Executor handshakes) {
        this.channel = channel;
        this.plain = new Plain(channel, peer);
        this.engine = engine;
        this.handshakes = handshakes;
    }

    @Override
    public InetSocketAddress peer() throws IOException {
        return plain.peer();
    }

    @Override
    public SelectionKey register(
            EventLoop eventLoop, EventLoop.Handler handler, Runnable whenReadable)
            throws IOException {
        loop = eventLoop;
        readable = whenReadable;
        key = plain.register(eventLoop, handler, whenReadable);
        return key;
    }

    @Override
    public boolean hasReceived() {
        return received.hasRemaining();
    }

    @Override
    public void expectMuch() throws IOException {
        plain.expectMuch();
    }

    @Override
    public int read(ByteBuffer into) throws IOException {
        if (bypassed) {
            return plain.read(into);
        }
        boolean open = hasReceived() || computing || decrypt();
        int count = Math.min(into.remaining(), received.remaining());
        into.put(received.slice().limit(count));
        received.position(received.position() + count);
        return count == 0 && !open ? -1 : count;
    }

    /**
     * Decrypts received data.
     *
     * @return false if the client has ended its output
     */
    private boolean decrypt() throws IOException {
        ByteBuffer in = SCRATCH.get().incoming.clear().put(incoming);
        incoming = NOTHING;
        boolean open = channel.read(in) >= 0;
        in.flip();
        if (!begun && in.hasRemaining()) {
            begun = true;
            if (in.get(0) != HANDSHAKE) {
                bypassed = true;
                throw new PlainTextException();
            }
        }
        try {
            open &= unwrap(in);
        } catch (SSLException e) {
            tellWhy();
            throw e;
        }
        return open;
    }

    /**
     * Decrypts the received bytes in a buffer.
     *
     * @return false if the client has ended its output
     */
    private boolean unwrap(ByteBuffer in) throws IOException {
        ByteBuffer out = SCRATCH.get().received.clear();
        boolean open = true;
        boolean more = true;
        while (open && more && !computing) {
            switch (engine.getHandshakeStatus()) {
                case NEED_TASK -> compute();
                case NEED_WRAP -> more = wrap(NOTHING);
                default -> {
                    SSLEngineResult result = engine.unwrap(in, out);
                    requireData(result);
                    shaken |= result.getHandshakeStatus() == HandshakeStatus.FINISHED;
                    open = result.getStatus() != SSLEngineResult.Status.CLOSED;
                    more = result.getStatus() == SSLEngineResult.Status.OK;
                }
            }
        }
        incoming = copy(in);
        received = copy(out.flip());
        return open;
    }

    private void requireData(SSLEngineResult result) throws SSLException {
        if (shaken
                && result.bytesConsumed() > 0
                && result.bytesProduced() == 0
                && ++recordsWithoutData > MOST_RECORDS_WITHOUT_DATA) {
            throw new SSLException(
                    "more than "
                            + MOST_RECORDS_WITHOUT_DATA
                            + " records without data, such as changes of keys");
        }
    }

    /**
     * Runs the computations of the handshake, such as signatures and checks, on another thread.
     * Nothing is read from the client meanwhile.
     */
    private void compute() {
        computing = true;
        interest(SelectionKey.OP_READ, false);
        EventLoop told = Objects.requireNonNull(loop);
        handshakes.execute(
                () -> {
                    // The check of the channel is needed, because the client may have disconnected
                    // while this task waited for a thread.
                    while (channel.isOpen() && engine.getDelegatedTask() instanceof Runnable task) {
                        task.run();
                    }
                    told.later(this::computed);
                });
    }

    private void computed() {
        computing = false;
        if (channel.isOpen()) {
            interest(SelectionKey.OP_READ, true);
            Objects.requireNonNull(readable).run();
        }
    }

    @Override
    public boolean hasUnsent() {
        return outgoing.hasRemaining();
    }

    @Override
    public int write(ByteBuffer bytes) throws IOException {
        if (bypassed) {
            return plain.write(bytes);
        }
        int before = bytes.remaining();
        if (flush() && bytes.hasRemaining() && !shaken) {
            throw new SSLException("the client has not shaken hands");
        }
        while ((bytes.hasRemaining() || isToWrap()) && wrap(bytes)) {
            // The loop body is empty, because each call of wrap() encrypts and writes one record.
        }
        if (bytes.hasRemaining() && engine.isOutboundDone()) {
            throw new SSLException("the connection is closed");
        }
        return before - bytes.remaining();
    }

    private boolean isToWrap() {
        return engine.getHandshakeStatus() == HandshakeStatus.NEED_WRAP;
    }

    /**
     * Encrypts data into one TLS record and writes it to the socket.
     *
     * @return false if the socket does not accept the whole record now
     */
    private boolean wrap(ByteBuffer bytes) throws IOException {
        if (!flush()) {
            return false;
        }
        ByteBuffer out = SCRATCH.get().outgoing.clear();
        SSLEngineResult result = engine.wrap(bytes, out);
        shaken |= result.getHandshakeStatus() == HandshakeStatus.FINISHED;
        channel.write(out.flip());
        outgoing = copy(out);
        if (hasUnsent()) {
            interest(SelectionKey.OP_WRITE, true);
        }
        return !hasUnsent() && result.getStatus() == SSLEngineResult.Status.OK;
    }

    private boolean flush() throws IOException {
        if (hasUnsent()) {
            channel.write(outgoing);
        }
        return !hasUnsent();
    }

    /** Sends the TLS alert that reports the error to the client, if the socket accepts it now. */
    private void tellWhy() {
        try {
            wrap(NOTHING);
        } catch (IOException e) {
            // The exception is ignored, because the alert is optional: the connection ends with or
            // without it.
        }
    }

    @Override
    public void shutdownOutput() throws IOException {
        if (!bypassed) {
            engine.closeOutbound();
            wrap(NOTHING);
            bypassed = true; // TLS is bypassed, and further input is discarded
        }
        plain.shutdownOutput();
    }

    @Override
    public boolean isOpen() {
        return channel.isOpen();
    }

    @Override
    public void close() throws IOException {
        channel.close();
    }

    private void interest(int operation, boolean wanted) {
        SelectionKey ownKey = Objects.requireNonNull(key);
        if (ownKey.isValid()) {
            ownKey.interestOps(
                    wanted ? ownKey.interestOps() | operation : ownKey.interestOps() & ~operation);
        }
    }

    private static ByteBuffer copy(ByteBuffer rest) {
        return rest.hasRemaining()
                ? ByteBuffer.allocate(rest.remaining()).put(rest).flip()
                : NOTHING;
    }
}
