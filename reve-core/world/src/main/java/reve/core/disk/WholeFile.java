// SPDX-License-Identifier: Apache-2.0
package reve.core.disk;

import java.io.BufferedOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;

/**
 * A file that is written under a temporary name, and moved to its place when it is complete. For
 * one thread.
 */
public final class WholeFile implements AutoCloseable {
    private static final int BUFFER_BYTES = 1 << 16;

    private final Path place;
    private final Path part;
    private final OutputStream out;
    private boolean closed;

    /**
     * Creates the file.
     *
     * @throws IOException if it cannot be created, or a folder, pipe or device is at the place
     */
    public WholeFile(Path place) throws IOException {
        if (Files.exists(place) && !Files.isRegularFile(place)) {
            // A device such as /dev/null must not be replaced by a file.
            throw new IOException("it is no regular file, expected a file or nothing");
        }
        this.place = place;
        this.part = PartFile.create(place);
        this.out = new BufferedOutputStream(Files.newOutputStream(part), BUFFER_BYTES);
    }

    /** A function that writes the content of a file. */
    @FunctionalInterface
    public interface Content {
        /** Writes the content to the stream, which the caller closes. */
        void write(OutputStream out) throws IOException;
    }

    /**
     * Writes a whole file. An older file at the place stays as it is if the write fails.
     *
     * @throws IOException naming the file and the reason
     */
    public static void write(Path place, Content content) throws IOException {
        try (var file = new WholeFile(place)) {
            content.write(file.out());
            file.finish();
        } catch (IOException e) {
            throw Reason.naming(place, e);
        }
    }

    /** Returns the stream for the content. This object closes the stream. */
    public OutputStream out() {
        return out;
    }

    /** Moves the complete file to its place. Replaces an existing file. */
    public void finish() throws IOException {
        closed = true;
        try {
            out.close();
            PartFile.move(part, place, StandardCopyOption.REPLACE_EXISTING);
        } catch (IOException e) {
            PartFile.remove(part);
            throw e;
        }
    }

    /** Removes the file unless it is complete. */
    @Override
    public void close() throws IOException {
        if (!closed) {
            closed = true;
            try {
                out.close();
            } catch (IOException e) {
                // The exception is ignored. The rest of the data cannot be written to a full disk,
                // and it is not needed.
            }
            PartFile.remove(part);
        }
    }
}
