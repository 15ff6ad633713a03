// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import reve.core.agent.protocol.AgentLimits;
import reve.core.agent.protocol.AgentTimeouts;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.Encoding;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.ReadableByteChannel;
import java.util.Arrays;

/**
 * Splits received bytes into messages: lines of JSON, or MessagePack with a length prefix. Enforces
 * limits of length and time. The buffer grows with the data received. A length prefix alone does
 * not make the buffer grow, so a client cannot reserve memory without sending data. For the event
 * loop's thread only.
 */
final class MessageFramer {

    /**
     * Initial size of the buffer before the hello [bytes]. It is small, because many connections
     * may send nothing.
     */
    private static final int FIRST_BYTES = 128;

    private static final int INITIAL_BYTES = 1024;
    private static final int KEPT_BYTES = 16 * 1024;

    private final AgentLimits limits;
    private final AgentTimeouts timeouts;
    private final Runnable ping;
    private ByteBuffer buffer = ByteBuffer.allocate(FIRST_BYTES);
    private int start;
    private int searched;
    private int end;
    private boolean drained;
    private Encoding encoding = Encoding.JSON;
    private boolean greeted;
    private boolean pinged;
    private long waitingSince = System.nanoTime();
    private long helloBytes;

    /**
     * @param ping sends a ping to a silent client
     */
    MessageFramer(AgentLimits limits, AgentTimeouts timeouts, Runnable ping) {
        this.limits = limits;
        this.timeouts = timeouts;
        this.ping = ping;
    }

    /** Switches from the limits of the hello to the limits of messages. */
    void greeted(Encoding ofWhatFollows) {
        greeted = true;
        encoding = ofWhatFollows;
        waitingSince = System.nanoTime();
    }

    /**
     * Reads available data. The caller must first call {@link #next} until it returns null.
     *
     * @return false if the client has closed the connection
     * @throws CloseReason if the client exceeded a limit
     */
    boolean fill(ReadableByteChannel in) throws IOException, CloseReason {
        makeRoom();
        int room = buffer.capacity() - end;
        if (!greeted) {
            if (helloBytes >= limits.helloBytes()) {
                throw CloseReason.cut(
                        "hello-too-long", "no hello within " + limits.helloBytes() + " bytes");
            }
            room = (int) Math.min(room, limits.helloBytes() - helloBytes);
        }
        int count = in.read(buffer.limit(end + room).position(end));
        drained = buffer.hasRemaining();
        if (count > 0 && !greeted && helloBytes == 0 && buffer.get(end) == TlsWire.HANDSHAKE) {
            throw CloseReason.refused(
                    "tls-unsupported", "this server speaks no TLS", "connect without TLS");
        }
        if (count > 0) {
            if (start == end && greeted) {
                waitingSince = System.nanoTime();
            }
            pinged = false;
            end += count;
            helloBytes += greeted ? 0 : count;
        }
        return count >= 0;
    }

    /**
     * Returns the next complete message.
     *
     * @return the message without line end or length prefix, valid until the next call; null if no
     *     message is complete
     * @throws CloseReason if the client exceeded a limit
     */
    @Nullable ByteBuffer next() throws CloseReason {
        ByteBuffer message = encoding == Encoding.JSON ? line() : packed();
        if (message != null && greeted) {
            waitingSince = System.nanoTime();
        }
        return message;
    }

    /** Returns whether {@link #fill} read all available data. */
    boolean hasTakenAll() {
        return drained;
    }

    /**
     * Checks time limits; sends a ping to a silent client. Called periodically.
     *
     * @throws CloseReason if the client exceeded a time limit
     */
    void checkTime(long nowNanos) throws CloseReason {
        boolean begun = end > start;
        if (nowNanos - waitingSince < limitNanos(begun)) {
            return;
        }
        if (!greeted) {
            throw CloseReason.cut(
                    "hello-late", "no hello within " + seconds(timeouts.hello().toMillis()));
        }
        if (begun) {
            throw CloseReason.cut(
                    "line-late",
                    "a line was not complete after " + seconds(timeouts.line().toMillis()));
        }
        if (pinged) {
            throw CloseReason.cut(
                    "idle", "no answer to a ping within " + seconds(timeouts.idle().toMillis()));
        }
        ping.run();
        pinged = true;
        waitingSince = nowNanos;
    }

    private @Nullable ByteBuffer line() {
        byte[] bytes = buffer.array();
        int at = searched;
        while (at < end && bytes[at] != '\n') {
            at++;
        }
        searched = at;
        if (at == end) {
            return null;
        }
        ByteBuffer line = buffer.slice(start, at - start);
        searched++;
        start = searched;
        return line;
    }

    private @Nullable ByteBuffer packed() throws CloseReason {
        if (end - start < Encoding.LENGTH_BYTES) {
            return null;
        }
        int length = buffer.limit(end).getInt(start);
        if (length < 0 || length > limits.lineBytes() - Encoding.LENGTH_BYTES) {
            throw CloseReason.cut(
                    "line-too-long",
                    "a message of "
                            + Integer.toUnsignedString(length)
                            + " bytes is longer than "
                            + limits.lineBytes());
        }
        if (end - start - Encoding.LENGTH_BYTES < length) {
            return null;
        }
        ByteBuffer message = buffer.slice(start + Encoding.LENGTH_BYTES, length);
        start += Encoding.LENGTH_BYTES + length;
        searched = start;
        return message;
    }

    private void makeRoom() throws CloseReason {
        if (end - start >= limits.lineBytes()) {
            throw CloseReason.cut(
                    "line-too-long", "a line is longer than " + limits.lineBytes() + " bytes");
        }
        byte[] bytes = buffer.array();
        if (start == end) {
            start = 0;
            searched = 0;
            end = 0;
            if (bytes.length > KEPT_BYTES || greeted && bytes.length < INITIAL_BYTES) {
                // A large buffer was needed only for one long line, or for the hello. It is
                // replaced by a small buffer, because later messages are usually short.
                buffer = ByteBuffer.allocate(INITIAL_BYTES);
            }
        } else if (end == bytes.length && start > 0) {
            System.arraycopy(bytes, start, bytes, 0, end - start);
            searched -= start;
            end -= start;
            start = 0;
        } else if (end == bytes.length) {
            buffer =
                    ByteBuffer.wrap(
                            Arrays.copyOf(bytes, Math.min(2 * bytes.length, limits.lineBytes())));
        }
    }

    private long limitNanos(boolean begun) {
        return (!greeted ? timeouts.hello() : begun ? timeouts.line() : timeouts.idle()).toNanos();
    }

    private static String seconds(long millis) {
        return millis / 1000.0 + " s";
    }
}
