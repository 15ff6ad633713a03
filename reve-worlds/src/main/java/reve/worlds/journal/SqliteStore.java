package reve.worlds.journal;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.PreparedStatement;
import java.sql.ResultSet;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.List;
import java.util.function.Consumer;
import java.util.zip.CRC32C;
import org.sqlite.SQLiteConfig;
import org.sqlite.SQLiteErrorCode;
import reve.core.store.CorruptException;
import reve.worlds.Product;

/**
 * A durable store of one world: an SQLite database in write-ahead-log mode with the last three
 * images and the law libraries, and beside it files of the frames since the oldest of them. One
 * thread at a time, but for {@link #sync} and places; one process, which locks the database.
 */
public final class SqliteStore implements JournalSink {
    /** "REVE" in SQLite's header: whose file it is. */
    private static final int APPLICATION_ID = 0x52455645;
    private static final int VERSION = 2;
    private static final int GENERATIONS = 3;
    private static final String SCHEMA = """
            CREATE TABLE library (sha256 TEXT PRIMARY KEY, bytes BLOB NOT NULL);
            CREATE TABLE image (frames_file INTEGER PRIMARY KEY, frame INTEGER NOT NULL,
                bytes BLOB NOT NULL, crc32c INTEGER NOT NULL)""";

    /** Where SQLite's own code is looked for, before it is unpacked into a temporary file. */
    private static final String LIBRARY_FOLDER = "org.sqlite.lib.path";

    static {
        if (System.getProperty(LIBRARY_FOLDER) == null) {
            System.setProperty(LIBRARY_FOLDER, Product.nativeFolder().toAbsolutePath().toString());
        }
    }

    private final Path file;
    private final Durability durability;
    private final FrameFiles frames;
    private Connection connection;

    /** How much a power failure may cost; the end of the process alone never costs a record. */
    public enum Durability {
        /** Frames of the last 0.1 s, and those that come while an image is written. */
        FULL,
        /** The frames since the last image. */
        NORMAL
    }

    /**
     * Opens a store, or makes an empty one where there is no file.
     *
     * @throws CorruptException if the file is something else, of another version, or damaged so
     *     that its tables cannot be read
     * @throws IOException if it cannot be opened, or another process has it open
     */
    public SqliteStore(Path file, Durability durability) throws IOException {
        this.file = file;
        this.durability = durability;
        connection = open();
        try (Statement statement = connection.createStatement()) {
            frames = new FrameFiles(file, number(statement, "SELECT max(frames_file) FROM image"));
        } catch (SQLException e) {
            closeAfter(connection, e);
            throw failed("read", e);
        } catch (IOException e) {
            closeAfter(connection, e);
            throw e;
        }
    }

    private Connection open() throws IOException {
        requirePlace(file);
        boolean isNew = !Files.exists(file) || Files.size(file) == 0;
        if (!isNew) {
            requireMark(file);
        }
        SQLiteConfig config = new SQLiteConfig();
        config.setJournalMode(SQLiteConfig.JournalMode.WAL);
        config.setSynchronous(SQLiteConfig.SynchronousMode.FULL);
        config.setLockingMode(SQLiteConfig.LockingMode.EXCLUSIVE);
        config.setBusyTimeout(0);
        Connection opened;
        try {
            opened = config.createConnection("jdbc:sqlite:" + file.toAbsolutePath());
        } catch (SQLException e) {
            throw failed("opened", e);
        }
        try (Statement statement = opened.createStatement()) {
            if (isNew) {
                create(statement);
            } else {
                check(statement);
            }
            statement.executeUpdate("PRAGMA user_version = " + VERSION); // locks the file
            opened.setAutoCommit(false);
            return opened;
        } catch (SQLException e) {
            closeAfter(opened, e);
            throw failed("opened", e);
        } catch (RuntimeException e) {
            closeAfter(opened, e);
            throw e;
        }
    }

    /** Whether there is no image in it. */
    public boolean isEmpty() throws IOException {
        try (Statement statement = connection.createStatement();
                ResultSet any = statement.executeQuery("SELECT 1 FROM image LIMIT 1")) {
            return !any.next();
        } catch (SQLException e) {
            throw failed("read", e);
        }
    }

    /**
     * What it takes to have the world as it was last: libraries, the newest image that can be read,
     * and the frames after it.
     *
     * @param problems told of every record that is damaged and was passed over
     * @throws CorruptException if no image can be read
     */
    public List<JournalRecord> read(Consumer<String> problems) throws IOException {
        try (Statement statement = connection.createStatement()) {
            List<JournalRecord> records = new ArrayList<>(readLibraries(statement));
            long framesFile = readImage(statement, records, problems);
            frames.read(framesFile, records::add, problems);
            return records;
        } catch (SQLException e) {
            throw failed("read", e);
        }
    }

    @Override
    public void write(JournalRecord record) throws IOException {
        frames.write(record);
    }

    @Override
    public Place place() {
        FrameFiles.Finished before = frames.next();
        long framesFile = frames.number();
        return (libraries, image) -> {
            try (before) {
                write(framesFile, libraries, image);
            }
        };
    }

    private void write(long framesFile, List<JournalRecord.Library> libraries,
            JournalRecord.Image image) throws IOException {
        requirePresent();
        try {
            for (JournalRecord.Library library : libraries) {
                insert("INSERT OR IGNORE INTO library VALUES (?, ?)", library.sha256(),
                        library.bytes());
            }
            insert("INSERT OR REPLACE INTO image VALUES (?, ?, ?, ?)", framesFile, image.frame(),
                    image.bytes(), checksum(image.bytes(), framesFile, image.frame()));
            long oldest = dropOld();
            connection.commit();
            frames.dropBefore(oldest);
        } catch (SQLException e) {
            rollback(e);
            throw failed("written", e);
        }
    }

    /** What is written to a file that was removed is lost: begins it anew. */
    private void requirePresent() throws IOException {
        if (Files.exists(file)) {
            return;
        }
        var removed = new IOException(file + " was removed; it has been made anew");
        closeAfter(connection, removed);
        connection = open();
        throw removed;
    }

    @Override
    public void sync() throws IOException {
        if (durability == Durability.FULL) {
            frames.force();
        }
    }

    @Override
    public void close() throws IOException {
        try (FrameFiles.Finished _ = frames.next()) {
            connection.close();
        } catch (SQLException e) {
            throw failed("closed", e);
        }
    }

    private void create(Statement statement) throws SQLException {
        statement.executeUpdate("PRAGMA application_id = " + APPLICATION_ID);
        for (String table : SCHEMA.split(";")) {
            statement.executeUpdate(table);
        }
    }

    private void check(Statement statement) throws SQLException {
        long application = number(statement, "PRAGMA application_id");
        if (application != APPLICATION_ID) {
            throw new CorruptException(file + " is an SQLite database but no store of REVE;"
                    + " name another file");
        }
        long version = number(statement, "PRAGMA user_version");
        if (version != VERSION) {
            throw new CorruptException(file + " is a store of version " + version
                    + ", this program reads and writes " + VERSION);
        }
        try (ResultSet result = statement.executeQuery("PRAGMA integrity_check(1)")) {
            String found = result.next() ? result.getString(1) : "nothing";
            if (!found.equals("ok")) {
                throw new CorruptException(file + " is damaged: " + found + "; put a copy in its "
                        + "place, or name another file");
            }
        }
    }

    private List<JournalRecord> readLibraries(Statement statement) throws SQLException {
        List<JournalRecord> libraries = new ArrayList<>();
        try (ResultSet row = statement.executeQuery("SELECT sha256, bytes FROM library")) {
            while (row.next()) {
                libraries.add(new JournalRecord.Library(row.getString(1), row.getBytes(2)));
            }
        }
        return libraries;
    }

    /** Adds the newest image that can be read, and gives the number of the file of its frames. */
    private long readImage(Statement statement, List<JournalRecord> into,
            Consumer<String> problems) throws SQLException {
        try (ResultSet row = statement.executeQuery(
                "SELECT frames_file, frame, bytes, crc32c FROM image ORDER BY frames_file DESC")) {
            while (row.next()) {
                long framesFile = row.getLong(1);
                long frame = row.getLong(2);
                byte[] bytes = row.getBytes(3);
                if (bytes != null && row.getLong(4) == checksum(bytes, framesFile, frame)) {
                    into.add(new JournalRecord.Image(frame, bytes));
                    return framesFile;
                }
                problems.accept(file + ": the image of frame " + frame
                        + " is damaged; going back to the one before it");
            }
        }
        throw new CorruptException(file + " holds no image that can be read; put a copy of it and "
                + "its files in its place, or name another file");
    }

    /** Keeps the last images; the number of the file of the frames after the oldest of them. */
    private long dropOld() throws SQLException {
        try (Statement statement = connection.createStatement()) {
            statement.executeUpdate("DELETE FROM image WHERE frames_file NOT IN "
                    + "(SELECT frames_file FROM image ORDER BY frames_file DESC LIMIT "
                    + GENERATIONS + ")");
            return number(statement, "SELECT min(frames_file) FROM image");
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

    private void rollback(SQLException after) {
        try {
            connection.rollback();
        } catch (SQLException e) {
            after.addSuppressed(e);
        }
    }

    private static void closeAfter(Connection connection, Exception failure) {
        try {
            connection.close();
        } catch (SQLException e) {
            failure.addSuppressed(e);
        }
    }

    private IOException failed(String what, SQLException e) {
        if (e.getErrorCode() == SQLiteErrorCode.SQLITE_BUSY.code) {
            return new IOException(file + " is in use by another process (the database is locked);"
                    + " end that one first, or name another file", e);
        }
        return new IOException(file + " could not be " + what + ": " + e.getMessage(), e);
    }

    private static long number(Statement statement, String sql) throws SQLException {
        try (ResultSet result = statement.executeQuery(sql)) {
            return result.next() ? result.getLong(1) : 0;
        }
    }

    private static void requirePlace(Path file) throws IOException {
        Path parent = file.toAbsolutePath().getParent();
        if (Files.isDirectory(file) || parent == null) {
            throw new IOException(file + " is a folder, expected a file");
        }
        if (!Files.isDirectory(parent)) {
            throw new IOException(file + " could not be opened: there is no folder " + parent);
        }
    }

    private static void requireMark(Path file) throws IOException {
        byte[] start = new byte[16];
        try (var in = Files.newInputStream(file)) {
            if (in.readNBytes(start, 0, 16) < 16
                    || !new String(start, StandardCharsets.ISO_8859_1)
                            .equals("SQLite format 3\0")) {
                throw new CorruptException(file + " is no store of REVE; name another file");
            }
        }
    }

    private static long checksum(byte[] bytes, long... numbers) {
        var crc = new CRC32C();
        for (long number : numbers) {
            crc.update(ByteBuffer.allocate(Long.BYTES).putLong(number).flip());
        }
        crc.update(bytes);
        return crc.getValue();
    }
}
