// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.disk.OwnedFile;
import reve.core.image.CorruptException;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.PreparedStatement;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.HashSet;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Set;
import java.util.UUID;
import java.util.function.Predicate;
import java.util.stream.Stream;

/**
 * A durable store of one world. An SQLite database in write-ahead-log mode contains the last three
 * images and the law libraries. Files beside it contain the frames since the oldest image, and a
 * manifest that lists the expected content. For one thread at a time, except {@link #sync} and
 * {@link JournalSink.Place}. The database is locked, so that only one process at a time has it
 * open.
 *
 * <p>The path of the database may lead to a different file later, which may belong to another
 * server. In this case that file and the files beside it are not changed, and the store continues
 * under a new name.
 */
public final class SqliteStore implements JournalSink {
    private static final int GENERATIONS = 3;

    private final Durability durability;
    private final Set<String> damagedLibraries;
    private final Set<String> told = new HashSet<>();
    private volatile Target target;
    private Connection connection;

    /** The file of the database that {@link #connection} has open. */
    private volatile FilePlace place;

    /** Minimum size of the database [bytes], for the detection of a truncated file. */
    private volatile long bytes;

    private boolean hasIdentity;

    /**
     * The files that receive the next image.
     *
     * @param since number of the first file of frames that contains the identity
     */
    private record Target(Path file, FrameFiles frames, UUID id, long since) {}

    /** The maximum loss by a power failure. A crash of the process alone never loses a record. */
    public enum Durability {
        /**
         * A power failure loses the frames of the last 0.1 s, and the frames that arrive while an
         * image is written.
         */
        FULL,
        /** A power failure loses the frames since the last image. */
        NORMAL
    }

    /**
     * Opens a store to resume from it, or creates an empty one. A refused store stays unchanged.
     *
     * @param contents the contents of the store, which the caller has just read; not retained
     * @throws CorruptException if the store is incomplete
     * @throws IOException if it cannot be opened, or another process has it open
     */
    public SqliteStore(StoreContents contents, Durability durability) throws IOException {
        contents.requireWhole();
        Path file = contents.file();
        try {
            OwnedFile.requireName(file, FrameFiles.LONGEST_ENDING);
        } catch (IOException e) {
            throw FileTrouble.of(file, "opened", e);
        }
        this.durability = durability;
        damagedLibraries = new HashSet<>(contents.damagedLibraries());
        hasIdentity = contents.hasIdentity();
        target =
                new Target(
                        file,
                        new FrameFiles(
                                file, contents.claim(), contents.lastFile(), contents.lastId()),
                        contents.id(),
                        contents.lastFile() + 1);
        connection = StoreDatabase.open(file);
        place = FilePlace.of(file);
        bytes = Files.size(file);
    }

    @Override
    public void write(JournalRecord record) throws IOException {
        target.frames.write(record);
    }

    @Override
    public Place place() throws IOException {
        FrameFiles left = target.frames;
        if (target.file.equals(place.path()) && place.isReplaced()) {
            target = elsewhere();
        }
        Target to = target;
        FrameFiles.Finished before = to.frames.next();
        long framesFile = to.frames.number();
        return (libraries, image) -> {
            try (before) {
                if (left != to.frames) {
                    left.close();
                }
                write(to, framesFile, libraries, image);
            }
        };
    }

    /** Returns a target with a file name that does not exist yet. */
    private Target elsewhere() throws IOException {
        Path taken = target.file.toAbsolutePath();
        Set<String> names = new HashSet<>();
        try (Stream<Path> siblings = Files.list(taken.getParent())) {
            siblings.forEach(sibling -> names.add(sibling.getFileName().toString()));
        }
        int number = 1;
        String name;
        do {
            name = taken.getFileName() + ".moved-" + number++;
        } while (names.contains(name) || names.stream().anyMatch(startOf(name)));
        Path file = target.file.resolveSibling(name);
        UUID id = UUID.randomUUID();
        return new Target(file, new FrameFiles(file, Manifest.Claim.nothing(id), 0, 0), id, 1);
    }

    private static Predicate<String> startOf(String store) {
        return name -> name.startsWith(store + "-");
    }

    private void write(
            Target to,
            long framesFile,
            List<JournalRecord.Library> libraries,
            JournalRecord.Image image)
            throws IOException {
        requireInPlace(to);
        FrameFiles frames = to.frames;
        Path file = to.file;
        frames.forceManifest();
        long sum = StoreDatabase.checksum(image.bytes(), framesFile, image.frame());
        long oldest;
        try {
            for (JournalRecord.Library library : libraries) {
                insert(
                        damagedLibraries.contains(library.sha256())
                                ? "INSERT OR REPLACE INTO library VALUES (?, ?)"
                                : "INSERT OR IGNORE INTO library VALUES (?, ?)",
                        library.sha256(),
                        library.bytes());
            }
            if (!hasIdentity) {
                identify(to);
            }
            insert(
                    "INSERT OR REPLACE INTO image VALUES (?, ?, ?, ?)",
                    framesFile,
                    image.frame(),
                    image.bytes(),
                    sum);
            oldest = dropOld();
            connection.commit();
        } catch (SQLException e) {
            rollback(e);
            throw FileTrouble.of(file, "written", e);
        }
        hasIdentity = true;
        libraries.forEach(library -> damagedLibraries.remove(library.sha256()));
        checkpoint(file);
        bytes = Files.exists(file) ? Files.size(file) : bytes;
        frames.keep(framesFile, image.frame(), sum);
        frames.dropBefore(oldest);
    }

    /**
     * Writes the store's identity with the first image. Later files of frames refer to this
     * identity.
     */
    private void identify(Target to) throws SQLException {
        try (Statement statement = connection.createStatement()) {
            statement.executeUpdate(StoreDatabase.IDENTITY_IF_ABSENT);
            statement.executeUpdate("DELETE FROM identity");
            insert("INSERT INTO identity VALUES (?, ?)", to.id.toString(), to.since);
            statement.executeUpdate("PRAGMA user_version = " + StoreDatabase.VERSION);
        }
    }

    /**
     * Moves the image from the write-ahead log to the database, so that nothing is lost if the log
     * is removed. The image stays in the log if the disk refuses the write.
     */
    private void checkpoint(Path file) throws IOException {
        try {
            connection.setAutoCommit(true);
            try (Statement statement = connection.createStatement()) {
                statement.execute("PRAGMA wal_checkpoint(TRUNCATE)");
            } catch (SQLException stays) {
                // The checkpoint failed, so the image stays in the log until a later checkpoint.
            }
            connection.setAutoCommit(false);
        } catch (SQLException e) {
            StoreDatabase.closeAfter(connection, e);
            throw FileTrouble.of(file, "written", e);
        }
    }

    /**
     * Opens the target's database. Creates it again if its file was removed, because data written
     * to a removed file is lost. Renames a file that was truncated.
     */
    private void requireInPlace(Target to) throws IOException {
        Path file = to.file;
        if (!file.equals(place.path())) {
            continueIn(file);
        }
        String trouble = place.trouble(bytes);
        if (trouble.isEmpty() && !isClosed(file)) {
            return;
        }
        if (place.isReplaced()) {
            // The file was replaced after the place for this image was reserved.
            throw new IOException(file + " " + trouble + "; the next image is written elsewhere");
        }
        var closing = new IOException(trouble);
        StoreDatabase.closeAfter(connection, closing);
        String kept = trouble.isEmpty() ? "" : moveAside(file);
        connection = StoreDatabase.open(file);
        place = FilePlace.of(file);
        bytes = Files.size(file);
        if (!trouble.isEmpty()) {
            hasIdentity = false;
            throw new BegunAnewException(file + " " + trouble + "; it was created again" + kept);
        }
    }

    /** Continues the store in another database, and reports this. */
    private void continueIn(Path file) throws IOException {
        Path left = place.path();
        StoreDatabase.closeAfter(connection, new IOException("replaced"));
        connection = StoreDatabase.open(file);
        place = FilePlace.of(file);
        bytes = Files.size(file);
        hasIdentity = false;
        damagedLibraries.clear();
        throw new BegunAnewException(
                left
                        + " was replaced by another file, which stays as it is, because another"
                        + " server may use it. The world is stored in "
                        + file
                        + " from now on; start a server with --store and that file to resume it");
    }

    private boolean isClosed(Path file) throws IOException {
        try {
            return connection.isClosed();
        } catch (SQLException e) {
            throw FileTrouble.of(file, "written", e);
        }
    }

    /**
     * Renames the file at the database's path.
     *
     * @return the new path, for messages; empty if there was no file
     */
    private String moveAside(Path file) throws IOException {
        if (!Files.exists(file, LinkOption.NOFOLLOW_LINKS)) {
            return "";
        }
        int number = 1;
        Path aside;
        do {
            aside = file.resolveSibling(file.getFileName() + ".replaced-" + number++);
        } while (Files.exists(aside, LinkOption.NOFOLLOW_LINKS));
        try {
            Files.move(file, aside);
        } catch (IOException e) {
            throw FileTrouble.of(file, "moved to " + aside, e);
        }
        return "; what was there is now " + aside;
    }

    @Override
    public List<String> troubles() {
        Target to = target;
        Set<String> now = new LinkedHashSet<>(to.frames.troubles());
        FilePlace known = place;
        String trouble = to.file.equals(known.path()) ? known.trouble(bytes) : "";
        if (!trouble.isEmpty()) {
            now.add(to.file + " " + trouble);
        }
        List<String> fresh =
                now.stream()
                        .filter(each -> !told.contains(each))
                        .map(
                                each ->
                                        each
                                                + ". The next image makes the store whole again,"
                                                + " and the server has to run until then; leave the"
                                                + " files of a store that is in use alone")
                        .toList();
        told.clear();
        told.addAll(now);
        return fresh;
    }

    @Override
    public void sync() throws IOException {
        if (durability == Durability.FULL) {
            target.frames.force();
        }
    }

    @Override
    public void close() throws IOException {
        try {
            target.frames.close();
        } finally {
            try {
                connection.close();
            } catch (SQLException e) {
                throw FileTrouble.of(place.path(), "closed", e);
            }
        }
    }

    /**
     * Removes all images but the last three. Returns the number of the file of frames that begins
     * with the oldest image kept.
     */
    private long dropOld() throws SQLException {
        try (Statement statement = connection.createStatement()) {
            statement.executeUpdate(
                    "DELETE FROM image WHERE frames_file NOT IN "
                            + "(SELECT frames_file FROM image ORDER BY frames_file DESC LIMIT "
                            + GENERATIONS
                            + ")");
            return StoreDatabase.number(statement, "SELECT min(frames_file) FROM image");
        }
    }

    private void insert(String sql, Object... values) throws SQLException {
        try (PreparedStatement statement = connection.prepareStatement(sql)) {
            for (int i = 0; i < values.length; i++) {
                statement.setObject(i + 1, values[i]);
            }
            statement.executeUpdate();
        }
    }

    /**
     * Undoes the changes of a failed write. SQLite has already undone them if the disk is full, and
     * the transaction state of the connection is then wrong. In this case the connection is closed,
     * and the next write opens a new one.
     */
    private void rollback(SQLException after) {
        try {
            connection.rollback();
        } catch (SQLException e) {
            after.addSuppressed(e);
            StoreDatabase.closeAfter(connection, after);
        }
    }
}
