// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import reve.core.disk.PartFile;

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
final class WholeFile implements AutoCloseable {
    private static final int BUFFER_BYTES = 1 << 16;

    private final Path place;
    private final Path part;
    private final OutputStream out;
    private boolean closed;

    /**
     * Creates the file.
     *
     * @throws IOException if it cannot be created
     */
    WholeFile(Path place) throws IOException {
        this.place = place;
        this.part = PartFile.create(place);
        this.out = new BufferedOutputStream(Files.newOutputStream(part), BUFFER_BYTES);
    }

    /** Returns the stream for the content. This object closes the stream. */
    OutputStream out() {
        return out;
    }

    /** Moves the complete file to its place. Replaces an existing file. */
    void finish() throws IOException {
        closed = true;
        try {
            out.close();
            Files.move(part, place, StandardCopyOption.REPLACE_EXISTING);
        } catch (IOException e) {
            Files.deleteIfExists(part);
            throw e;
        }
    }

    /** Removes the file unless it is complete. */
    @Override
    public void close() throws IOException {
        if (!closed) {
            closed = true;
            try (out) {
                Files.deleteIfExists(part);
            }
        }
    }
}
