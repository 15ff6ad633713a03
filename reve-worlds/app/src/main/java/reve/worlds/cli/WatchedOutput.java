// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import java.io.IOException;
import java.io.OutputStream;
import java.util.Optional;
import java.util.concurrent.atomic.AtomicLong;

/**
 * Standard output that tolerates a full disk or a closed pipe. It throws no exception, drops data
 * that cannot be written, and keeps the reason. Output continues on a new line after a gap. One
 * thread writes to it; any thread may query it.
 */
final class WatchedOutput extends OutputStream {
    private static final String CLOSED_PIPE = "Broken pipe";

    private final OutputStream out;
    private final AtomicLong failures = new AtomicLong();
    private volatile @Nullable String reason;
    private boolean torn;

    WatchedOutput(OutputStream out) {
        this.out = out;
    }

    @Override
    public void write(int one) {
        write(new byte[] {(byte) one}, 0, 1);
    }

    @Override
    public void write(byte[] bytes, int from, int length) {
        try {
            if (torn) {
                out.write('\n');
                torn = false;
            }
            out.write(bytes, from, length);
        } catch (IOException e) {
            torn = true;
            failed(e);
        }
    }

    @Override
    public void flush() {
        try {
            out.flush();
        } catch (IOException e) {
            failed(e);
        }
    }

    private void failed(IOException e) {
        reason = String.valueOf(e.getMessage());
        failures.incrementAndGet();
    }

    /** Returns the number of times that data was dropped. */
    long failures() {
        return failures.get();
    }

    /** Returns the reason of the last drop, if data was dropped. */
    Optional<String> reason() {
        return Optional.ofNullable(reason);
    }

    /** Returns whether the reader has closed the pipe, as {@code head} does. */
    boolean isClosedPipe() {
        return CLOSED_PIPE.equals(reason);
    }
}
