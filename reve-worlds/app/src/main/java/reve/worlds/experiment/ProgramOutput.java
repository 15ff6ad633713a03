// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.text.Visible;

import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;

/**
 * The output of a program, which a separate thread copies into a file. The file contains at most
 * {@link #MAX_BYTES}. Further output is dropped, so that no program fills the disk.
 */
final class ProgramOutput {
    /** Maximum number of bytes in the file, without the line that reports dropped output. */
    static final int MAX_BYTES = 16 << 20;

    private static final int BUFFER_BYTES = 1 << 16;

    private final InputStream from;
    private final Path file;
    private final int most;
    private final Thread copying;

    /**
     * Starts the thread that copies the output.
     *
     * @param most maximum number of bytes
     */
    ProgramOutput(InputStream from, Path file, int most) {
        this.from = from;
        this.file = file;
        this.most = most;
        this.copying = Thread.ofVirtual().name("output of a program").start(this::copy);
    }

    /** Waits until the output has ended, but at most for the given time. */
    void await(Duration longest) throws InterruptedException {
        copying.join(longest);
    }

    private void copy() {
        try (InputStream in = from) {
            copyTo(in);
            byte[] buffer = new byte[BUFFER_BYTES];
            while (in.read(buffer) >= 0) {
                // Further output is read and dropped, because the program would otherwise block.
            }
        } catch (IOException ended) {
            // The exception is ignored. It means that the program ended.
        }
    }

    /** Copies output until it ends, or the file has enough, or cannot be written. */
    private void copyTo(InputStream in) throws IOException {
        byte[] buffer = new byte[BUFFER_BYTES];
        long total = 0;
        try (OutputStream out = Files.newOutputStream(file)) {
            for (int read = in.read(buffer); read >= 0; read = in.read(buffer)) {
                int kept = (int) Math.min(read, Math.max(0, most - total));
                out.write(buffer, 0, kept);
                total += kept;
                if (kept < read) {
                    String end = "\n(further output is dropped: the file has " + most + " bytes)\n";
                    out.write(end.getBytes(StandardCharsets.UTF_8));
                    return;
                }
            }
        } catch (IOException full) {
            // The program continues without its output, like the rest of the experiment.
            System.err.println(
                    Visible.line("reve: the output of a program is lost: " + file + ": " + full));
        }
    }
}
