// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import java.util.Optional;

/** Where a journal is kept. One thread, except where it says otherwise. */
public interface JournalSink extends AutoCloseable {
    /**
     * Adds a library or a frame behind all else. When it returns, the record outlives the end of
     * this process.
     *
     * @throws IOException naming the file, if that failed; nothing of the record counts then
     */
    void write(JournalRecord record) throws IOException;

    /**
     * A place for an image of the frame that was written last, before all that is written later.
     *
     * @throws IOException naming the file, if there can be none
     */
    Place place() throws IOException;

    /**
     * Waits until what was written outlives a power failure too, if the sink was made for that. Any
     * thread, also while another one writes.
     */
    void sync() throws IOException;

    /** Its file, if that was moved or removed: readers do not find there what is written. */
    default Optional<Path> missing() {
        return Optional.empty();
    }

    /**
     * Looks at its files and returns a line about each that was removed, replaced or cut since the
     * last look, with what to do. The thread that writes images.
     */
    default List<String> troubles() {
        return List.of();
    }

    /** Whether it has the size that it was to have, and ends there. */
    default boolean hasItsLimit() {
        return false;
    }

    /**
     * Begins again with an empty file in place of one that is missing, or that refused a record.
     *
     * @return where that is, and what became of the file before it, for people
     * @throws IOException naming the file, if there can be none
     */
    default String beginAnew() throws IOException {
        throw new UnsupportedOperationException("no file is missing");
    }

    @Override
    void close() throws IOException;

    /** A file of the sink was lost, and another one has begun: the image is to be written again. */
    final class BegunAnewException extends IOException {
        private static final long serialVersionUID = 1L;

        public BegunAnewException(String message) {
            super(message);
        }
    }

    /** Where an image goes: any thread, also while another one writes; places in their order. */
    interface Place {
        /**
         * Keeps the image and the libraries that it names, all or nothing.
         *
         * @throws BegunAnewException if nothing was written, and trying again is likely to help
         * @throws IOException naming the file, if that failed; the place may be tried again
         */
        void write(List<JournalRecord.Library> libraries, JournalRecord.Image image)
                throws IOException;
    }
}
