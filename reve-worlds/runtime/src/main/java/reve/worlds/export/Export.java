// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import java.io.IOException;

/**
 * A file, or a folder of files, that receives the frames of a run in order. For one thread. The
 * files appear at their place only after {@link #finish()}. The method {@link #close()} removes the
 * written data if {@link #finish()} was not called.
 */
public interface Export extends AutoCloseable {
    /**
     * Adds a frame.
     *
     * @throws IOException if it cannot be written
     */
    void add(ExportedFrame frame) throws IOException;

    /**
     * Completes the files and moves them to their place.
     *
     * @throws IOException if they cannot be written or moved
     */
    void finish() throws IOException;

    /** Removes the files unless they are complete. */
    @Override
    void close() throws IOException;
}
