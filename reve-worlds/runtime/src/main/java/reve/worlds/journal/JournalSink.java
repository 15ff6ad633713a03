// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.SessionNote;

import java.io.IOException;
import java.time.Duration;
import java.util.List;
import java.util.Optional;
import java.util.function.Consumer;

/** The storage of a journal. For one thread, unless a method states otherwise. */
public interface JournalSink extends AutoCloseable {
    /**
     * Appends a library or a frame. The record survives the end of this process after the method
     * has returned.
     *
     * @throws IOException naming the file; the record is then not stored
     */
    void write(JournalRecord record) throws IOException;

    /**
     * Returns whether the sink stores notes about sessions, for the server that continues the world
     * if this server is lost. For any thread.
     */
    default boolean keepsSessions() {
        return false;
    }

    /**
     * Adds notes about sessions to the next frame or place. The notes are stored together with this
     * frame or place, or with a later one if it cannot be stored.
     */
    default void note(List<SessionNote> notes) {
        // Only shared stores are continued by other servers.
    }

    /**
     * Reserves the position of an image of the last written frame in the order of records. The
     * image comes before all records that are written later.
     *
     * @throws IOException naming the file, if no place can be reserved
     */
    Place place() throws IOException;

    /**
     * Flushes the written data to the disk, if the sink was configured to survive power failures.
     * For any thread, also during a write.
     */
    void sync() throws IOException;

    /**
     * Returns a message if the sink's file was moved, removed or truncated, so that readers would
     * miss new data. The message contains the name of the file and what happened. The result is
     * empty otherwise.
     */
    default Optional<String> missing() {
        return Optional.empty();
    }

    /**
     * Checks the sink's files and returns a line for each file that was removed, replaced or
     * truncated since the last check. Each line states what the operator must do. Called by the
     * thread that writes images.
     */
    default List<String> troubles() {
        return List.of();
    }

    /** Returns true if the sink has reached its size limit and accepts no more records. */
    default boolean hasItsLimit() {
        return false;
    }

    /**
     * Begins a new, empty file instead of one that is missing or could not be written.
     *
     * @return the new file and what happened to the previous one, for messages
     * @throws IOException naming the file, if no file can be created
     */
    default String beginAnew() throws IOException {
        throw new UnsupportedOperationException("no file is missing");
    }

    /**
     * Records the address at which agents connect to the world, for clients that look up the world
     * in a shared store. Called at most once, before the first frame.
     *
     * @param agents host and port of the server
     * @throws IOException if the store cannot be written; the world may run nevertheless
     */
    default void announce(String agents) throws IOException {
        // This implementation does nothing, because clients search shared stores only.
    }

    /**
     * Stores the sessions of clients, for the server that continues the world. Call this method
     * after the last frame. The world must not depend on them: a server that does not find the
     * sessions removes the agents.
     *
     * @param frame the last frame of the world
     * @throws IOException if they cannot be stored
     */
    default void handOver(long frame, List<CarriedSession> sessions) throws IOException {
        // Only shared stores are continued by other servers.
    }

    /**
     * Records that the world sleeps: no server runs it until a client requests it. Call this method
     * after the last frame. The record is no longer valid when a server takes the world.
     *
     * @throws IOException if it cannot be recorded
     */
    default void sleep() throws IOException {
        throw new UnsupportedOperationException("only worlds of a shared store sleep");
    }

    /**
     * Registers the listener that receives a message when another server has taken the sink's
     * store. Called at most once, on any thread. Sinks that only one process can open never call
     * it.
     */
    default void whenLost(Consumer<String> listener) {
        // No other server can take this sink, so the listener is never called.
    }

    /**
     * Limits the time of all writes and of {@link #close} together, because the process is about to
     * be ended. Writes that are not done within this time fail. For any thread; called at most
     * once.
     */
    default void hurry(Duration limit) {
        // This implementation does nothing, because a write to a disk cannot be accelerated.
    }

    @Override
    void close() throws IOException;

    /** Thrown if another running server has the store. */
    final class InUseException extends IOException {
        private static final long serialVersionUID = 1L;

        /** Creates an exception with a message that names the store and the server. */
        public InUseException(String message) {
            super(message);
        }
    }

    /**
     * Thrown if another server has taken the store of this sink. The sink accepts no further
     * records, so the world must stop.
     */
    final class LostException extends IOException {
        private static final long serialVersionUID = 1L;

        /** Creates an exception with a message that names the store and the other server. */
        public LostException(String message) {
            super(message);
        }
    }

    /** Thrown if the database of the sink cannot be reached at present. */
    final class AwayException extends IOException {
        private static final long serialVersionUID = 1L;

        /** Creates an exception with a message that names the database. */
        public AwayException(String message) {
            super(message);
        }
    }

    /**
     * Thrown if the sink has lost records that it had accepted. The journal must begin again with
     * an image.
     */
    final class GapException extends IOException {
        private static final long serialVersionUID = 1L;

        /** Creates an exception with a message that names the store and the lost records. */
        public GapException(String message) {
            super(message);
        }
    }

    /**
     * Thrown if a file of the sink was lost and a new file was begun. The image must then be
     * written again.
     */
    final class BegunAnewException extends IOException {
        private static final long serialVersionUID = 1L;

        /** Creates an exception with a message that names the file. */
        public BegunAnewException(String message) {
            super(message);
        }
    }

    /**
     * A reserved position for an image in the order of records. For any thread, also during a
     * write. Images must be written in the order of their positions.
     */
    interface Place {
        /**
         * Stores the image and the libraries that it refers to, either all or none of them.
         *
         * @throws BegunAnewException if nothing was written and a retry will probably succeed
         * @throws IOException naming the file, if the write failed; the write may be retried
         */
        void write(List<JournalRecord.Library> libraries, JournalRecord.Image image)
                throws IOException;
    }
}
