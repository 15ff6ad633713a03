// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Path;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.function.Consumer;

/** The place where a world is stored. */
public sealed interface StoreAddress {
    /**
     * Reads a store without changing it.
     *
     * @throws reve.core.image.CorruptException if it is not a store
     * @throws IOException if it cannot be read, or another process has it open
     */
    StoreReading read() throws IOException;

    /**
     * Reads a store like {@link #read}, with all frames that it contains. The records may begin
     * before the image from which a server would continue the world, and contain several images.
     */
    default StoreReading history() throws IOException {
        return read();
    }

    /**
     * Takes a store in order to resume its world.
     *
     * @param problems receives what the operator must know, on any thread
     * @throws reve.core.image.CorruptException if it is not a store
     * @throws IOException if it cannot be read, or another process has it
     */
    TakenStore take(SqliteStore.Durability durability, Consumer<String> problems)
            throws IOException;

    /**
     * Returns whether servers on several machines use the store. Such a store does not name the
     * folder of the world's files, because each machine has a different folder.
     */
    default boolean isShared() {
        return false;
    }

    /** A store in a file and the files beside it. */
    record InFile(Path file) implements StoreAddress {
        @Override
        public StoreReading read() throws IOException {
            return StoreContents.read(file);
        }

        @Override
        public TakenStore take(SqliteStore.Durability durability, Consumer<String> problems)
                throws IOException {
            StoreContents contents = StoreContents.read(file);
            return new TakenStore() {
                @Override
                public StoreReading contents() {
                    return contents;
                }

                @Override
                public OptionalLong epoch() {
                    return OptionalLong.empty();
                }

                @Override
                public JournalSink open() throws IOException {
                    return new SqliteStore(contents, durability);
                }

                @Override
                public void close() {
                    // This method does nothing, because reading the store leaves no file open.
                }
            };
        }

        @Override
        public String toString() {
            return file.toString();
        }
    }

    /**
     * A world in a database that several servers share.
     *
     * @param world the name of the world
     * @param pack file with the world and all files that it needs, which the store shall contain;
     *     empty if the store contains the world already
     */
    record InDatabase(PostgresUrl url, String world, Optional<Path> pack) implements StoreAddress {
        @Override
        public StoreReading read() throws IOException {
            return PostgresContents.of(this, false);
        }

        @Override
        public StoreReading history() throws IOException {
            return PostgresContents.of(this, true);
        }

        @Override
        public TakenStore take(SqliteStore.Durability durability, Consumer<String> problems)
                throws IOException {
            return PostgresStore.take(this, durability, problems);
        }

        @Override
        public boolean isShared() {
            return true;
        }

        @Override
        public String toString() {
            return url + " (" + world + ")";
        }
    }
}
