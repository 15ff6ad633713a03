// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.concurrent.TimeUnit;

/** A running {@code vesper-render} process and its scene stream. */
final class RenderProcess {

    private static final Duration LAST_WORDS = Duration.ofSeconds(2);
    private static final int KEPT_ERROR_CHARACTERS = 2000;

    private final Process process;
    private final SceneStream stream;
    private final StringBuffer errors = new StringBuffer();
    private final Thread errorReader;

    RenderProcess(Path program) throws IOException {
        process = new ProcessBuilder(List.of(program.toString())).start();
        stream = new SceneStream(process.getOutputStream(), process.getInputStream());
        // A platform thread reads the error output. A virtual thread would block its carrier thread
        // as long as the process lives, because reading a pipe blocks.
        errorReader =
                Thread.ofPlatform().daemon().name("vesper-render errors").start(this::keepErrors);
    }

    SceneStream stream() {
        return stream;
    }

    boolean isAlive() {
        return process.isAlive();
    }

    long pid() {
        return process.pid();
    }

    /** Ends the process. For any thread; a thread that waits for an answer gets an IOException. */
    void kill() {
        process.destroyForcibly();
    }

    /**
     * Returns how the process ended and its error output, for a message. Waits a short time for
     * both.
     */
    String describeEnd() {
        try {
            String end =
                    process.waitFor(LAST_WORDS.toMillis(), TimeUnit.MILLISECONDS)
                            ? "ended with exit code " + process.exitValue()
                            : "stopped answering";
            errorReader.join(LAST_WORDS);
            String output = errors.toString().strip();
            return output.isEmpty() ? end : end + " and said: " + output;
        } catch (InterruptedException interrupted) {
            Thread.currentThread().interrupt();
            return "ended";
        }
    }

    private void keepErrors() {
        try (InputStream in = process.getErrorStream()) {
            byte[] part = new byte[1024];
            for (int count = in.read(part); count >= 0; count = in.read(part)) {
                errors.append(new String(part, 0, count, StandardCharsets.UTF_8));
                errors.delete(0, Math.max(0, errors.length() - KEPT_ERROR_CHARACTERS));
            }
        } catch (IOException closed) {
            errors.append(" (and no more could be read: ").append(closed.getMessage()).append(')');
        }
    }
}
