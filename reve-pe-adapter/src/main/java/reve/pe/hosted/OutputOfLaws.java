// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.slf4j.Logger;

import java.io.BufferedInputStream;
import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;

/** Reads the standard output of laws. Logs the first lines of each second in a shortened form. */
final class OutputOfLaws implements Runnable {
    private static final int MOST_BYTES = 1024;
    private static final int MOST_LINES = 20;
    private static final long SECOND = 1_000_000_000L;

    private final Process process;
    private final Logger log;
    private final byte[] line = new byte[MOST_BYTES];
    private int length;
    private long since = System.nanoTime();
    private int lines;

    OutputOfLaws(Process process, Logger log) {
        this.process = process;
        this.log = log;
    }

    @Override
    public void run() {
        try (InputStream in = new BufferedInputStream(process.getInputStream())) {
            for (int next = in.read(); next >= 0; next = in.read()) {
                if (next == '\n') {
                    flush();
                } else if (length < MOST_BYTES) {
                    line[length++] = (byte) next;
                }
            }
            flush();
        } catch (IOException ended) {
            // The exception is ignored. It means that the process has ended, so no more output
            // follows.
        }
    }

    private void flush() {
        long now = System.nanoTime();
        if (now - since >= SECOND) {
            if (lines > MOST_LINES) {
                log.warn("laws printed {} more lines, which were dropped", lines - MOST_LINES);
            }
            since = now;
            lines = 0;
        }
        if (length > 0 && ++lines <= MOST_LINES) {
            log.warn(
                    "printed by a law: {}",
                    escaped(new String(line, 0, length, StandardCharsets.UTF_8)));
        }
        length = 0;
    }

    /** Returns text as one line of at most 1,000 characters, with control characters escaped. */
    static String escaped(String text) {
        StringBuilder safe = new StringBuilder(Math.min(text.length(), MOST_BYTES));
        for (int i = 0; i < text.length() && i < MOST_BYTES; i++) {
            char c = text.charAt(i);
            safe.append(
                    Character.isISOControl(c) || Character.getType(c) == Character.FORMAT
                            ? '?'
                            : c);
        }
        return safe.toString();
    }
}
