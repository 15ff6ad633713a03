package reve.core.agent;

import java.io.IOException;
import java.io.InputStream;
import java.net.Socket;
import java.net.SocketTimeoutException;
import java.nio.ByteBuffer;
import java.util.Arrays;
import java.util.concurrent.TimeUnit;
import org.jspecify.annotations.Nullable;

/**
 * Cuts what a client sends into messages: lines of JSON, or MessagePack behind its length; within limits of length and time. Memory grows with what has arrived, never
 * with what was announced. One thread.
 */
final class FrameReader {

    private static final int INITIAL_BYTES = 1024;
    private static final int KEPT_BYTES = 16 * 1024;

    private final Socket socket;
    private final InputStream in;
    private final AgentServerConfig config;
    private final Runnable ping;
    private byte[] buffer = new byte[INITIAL_BYTES];
    private int start;
    private int searched;
    private int end;
    private Encoding encoding = Encoding.JSON;
    private boolean greeted;
    private boolean pinged;
    private long waitingSince = System.nanoTime();
    private long helloBytes;

    /** @param ping asks a silent client whether it is still there */
    FrameReader(Socket socket, AgentServerConfig config, Runnable ping) throws IOException {
        this.socket = socket;
        this.in = socket.getInputStream();
        this.config = config;
        this.ping = ping;
    }

    /** The hello has come: from now on the limits of messages hold, no longer those of the hello. */
    void greeted(Encoding ofWhatFollows) {
        greeted = true;
        encoding = ofWhatFollows;
    }

    /**
     * Waits for a message.
     *
     * @return it without line end or length, valid until the next call; null where the client closed the connection
     * @throws Ending if the client broke a limit
     */
    @Nullable ByteBuffer next() throws IOException, Ending {
        boolean begun = end > start;
        waitingSince = greeted ? System.nanoTime() : waitingSince;
        while (true) {
            ByteBuffer message = encoding == Encoding.JSON ? line() : packed();
            if (message != null) {
                return message;
            }
            makeRoom();
            int count = fill(begun);
            if (count < 0) {
                return null;
            }
            pinged = false;
            if (!begun && greeted) {
                waitingSince = System.nanoTime();
            }
            begun = true;
        }
    }

    private @Nullable ByteBuffer line() {
        for (; searched < end; searched++) {
            if (buffer[searched] == '\n') {
                ByteBuffer line = ByteBuffer.wrap(buffer, start, searched - start);
                searched++;
                start = searched;
                return line;
            }
        }
        return null;
    }

    private @Nullable ByteBuffer packed() throws Ending {
        if (end - start < Encoding.LENGTH_BYTES) {
            return null;
        }
        int length = ByteBuffer.wrap(buffer, start, Encoding.LENGTH_BYTES).getInt();
        if (length < 0 || length > config.lineBytes() - Encoding.LENGTH_BYTES) {
            throw Ending.cut("line-too-long", "a message of " + Integer.toUnsignedString(length)
                    + " bytes is longer than " + config.lineBytes());
        }
        if (end - start - Encoding.LENGTH_BYTES < length) {
            return null;
        }
        ByteBuffer message = ByteBuffer.wrap(buffer, start + Encoding.LENGTH_BYTES, length).slice();
        start += Encoding.LENGTH_BYTES + length;
        searched = start;
        return message;
    }

    private void makeRoom() throws Ending {
        if (end - start >= config.lineBytes()) {
            throw Ending.cut("line-too-long", "a line is longer than " + config.lineBytes() + " bytes");
        }
        if (start == end && buffer.length > KEPT_BYTES) {
            buffer = new byte[INITIAL_BYTES]; // a long line is behind us
            start = 0;
            searched = 0;
            end = 0;
        } else if (start > 0) {
            System.arraycopy(buffer, start, buffer, 0, end - start);
            searched -= start;
            end -= start;
            start = 0;
        }
        if (end == buffer.length) {
            buffer = Arrays.copyOf(buffer, Math.min(2 * buffer.length, config.lineBytes()));
        }
    }

    private int fill(boolean begun) throws IOException, Ending {
        while (true) {
            long left = limitNanos(begun) - (System.nanoTime() - waitingSince);
            if (left > 0) {
                try {
                    socket.setSoTimeout((int) TimeUnit.NANOSECONDS.toMillis(left) + 1);
                    return read();
                } catch (SocketTimeoutException e) {
                    continue; // the clock decides
                }
            }
            if (!greeted) {
                throw Ending.cut("hello-late", "no hello within " + seconds(config.hello().toMillis()));
            }
            if (begun) {
                throw Ending.cut("line-late", "a line was not complete after " + seconds(config.line().toMillis()));
            }
            if (pinged) {
                throw Ending.cut("idle", "no answer to a ping within " + seconds(config.idle().toMillis()));
            }
            ping.run();
            pinged = true;
            waitingSince = System.nanoTime();
        }
    }

    private int read() throws IOException, Ending {
        int room = buffer.length - end;
        if (!greeted) {
            if (helloBytes >= config.helloBytes()) {
                throw Ending.cut("hello-too-long", "no hello within " + config.helloBytes() + " bytes");
            }
            room = (int) Math.min(room, config.helloBytes() - helloBytes);
        }
        int count = in.read(buffer, end, room);
        if (count > 0) {
            end += count;
            helloBytes += greeted ? 0 : count;
        }
        return count;
    }

    private long limitNanos(boolean begun) {
        return (!greeted ? config.hello() : begun ? config.line() : config.idle()).toNanos();
    }

    private static String seconds(long millis) {
        return millis / 1000.0 + " s";
    }
}
