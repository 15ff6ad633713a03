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
import reve.core.store.CorruptException;

/**
 * A durable store of one world: an SQLite database in write-ahead-log mode with the last three
 * images, the journal since the oldest of them, and the law libraries. Every record is one
 * transaction. One thread at a time; one process, which locks it.
 */
public final class SqliteStore implements JournalSink {
    /** "REVE" in SQLite's header: whose file it is. */
    private static final int APPLICATION_ID = 0x52455645;
    private static final int VERSION = 1;
    private static final int GENERATIONS = 3;
    private static final String SCHEMA = """
            CREATE TABLE library (sha256 TEXT PRIMARY KEY, bytes BLOB NOT NULL);
            CREATE TABLE image (id INTEGER PRIMARY KEY, frame INTEGER NOT NULL,
                bytes BLOB NOT NULL, crc32c INTEGER NOT NULL);
            CREATE TABLE journal (id INTEGER PRIMARY KEY, image INTEGER NOT NULL,
                first_frame INTEGER NOT NULL, last_frame INTEGER NOT NULL, lines BLOB NOT NULL,
                crc32c INTEGER NOT NULL)""";

    private final Path file;
    private final Connection connection;

    /** How much a power failure may cost; the end of the process alone never costs a record. */
    public enum Durability {
        /** Nothing that was written: the disk is waited for at every record. */
        FULL,
        /** The last records, never the whole. */
        NORMAL
    }

    /**
     * Opens a store, or makes an empty one where there is no file.
     *
     * @throws CorruptException if the file is something else, of a newer version, or damaged so that
     *     its tables cannot be read
     * @throws IOException if it cannot be opened, or another process has it open
     */
    public SqliteStore(Path file, Durability durability) throws IOException {
        this.file = file;
        boolean isNew = !Files.exists(file) || Files.size(file) == 0;
        if (!isNew) {
            requireMark(file);
        }
        SQLiteConfig config = new SQLiteConfig();
        config.setJournalMode(SQLiteConfig.JournalMode.WAL);
        config.setSynchronous(durability == Durability.FULL
                ? SQLiteConfig.SynchronousMode.FULL : SQLiteConfig.SynchronousMode.NORMAL);
        config.setLockingMode(SQLiteConfig.LockingMode.EXCLUSIVE);
        config.setBusyTimeout(0);
        try {
            connection = config.createConnection("jdbc:sqlite:" + file.toAbsolutePath());
        } catch (SQLException e) {
            throw failed("opened", e);
        }
        try (Statement statement = connection.createStatement()) {
            if (isNew) {
                create(statement);
            } else {
                check(statement);
            }
            statement.executeUpdate("PRAGMA user_version = " + VERSION); // locks the file
            connection.setAutoCommit(false);
        } catch (SQLException e) {
            closeAfter(e);
            throw failed("opened", e);
        } catch (RuntimeException e) {
            closeAfter(e);
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
     * and the journal after it.
     *
     * @param problems told of every record that is damaged and was passed over
     * @throws CorruptException if no image can be read
     */
    public List<JournalRecord> read(Consumer<String> problems) throws IOException {
        try (Statement statement = connection.createStatement()) {
            List<JournalRecord> records = new ArrayList<>(readLibraries(statement));
            long image = readImage(statement, records, problems);
            readJournal(statement, image, records, problems);
            return records;
        } catch (SQLException e) {
            throw failed("read", e);
        }
    }

    @Override
    public void write(JournalRecord record) throws IOException {
        try {
            switch (record) {
                case JournalRecord.Library library -> insert(
                        "INSERT OR REPLACE INTO library VALUES (?, ?)", library.sha256(),
                        library.bytes());
                case JournalRecord.Image image -> {
                    insert("INSERT INTO image (frame, bytes, crc32c) VALUES (?, ?, ?)",
                            image.frame(), image.bytes(), checksum(image.bytes(), image.frame()));
                    dropOld();
                }
                case JournalRecord.Frames frames -> insert("INSERT INTO journal (image, first_frame,"
                        + " last_frame, lines, crc32c) SELECT max(id), ?, ?, ?, ? FROM image",
                        frames.first(), frames.last(), frames.lines(),
                        checksum(frames.lines(), frames.first(), frames.last()));
            }
            connection.commit();
        } catch (SQLException e) {
            rollback(e);
            throw failed("written", e);
        }
    }

    @Override
    public void close() throws IOException {
        try {
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

    /** Adds the newest image that can be read, and gives its id. */
    private long readImage(Statement statement, List<JournalRecord> into,
            Consumer<String> problems) throws SQLException {
        try (ResultSet row = statement.executeQuery(
                "SELECT id, frame, bytes, crc32c FROM image ORDER BY id DESC")) {
            while (row.next()) {
                long frame = row.getLong(2);
                byte[] bytes = row.getBytes(3);
                if (bytes != null && row.getLong(4) == checksum(bytes, frame)) {
                    into.add(new JournalRecord.Image(frame, bytes));
                    return row.getLong(1);
                }
                problems.accept(file + ": the image of frame " + frame
                        + " is damaged; going back to the one before it");
            }
        }
        throw new CorruptException(file + " holds no image that can be read");
    }

    /** Adds the records after an image, up to the first that is damaged or missing. */
    private void readJournal(Statement statement, long image, List<JournalRecord> into,
            Consumer<String> problems) throws SQLException {
        try (ResultSet row = statement.executeQuery("SELECT first_frame, last_frame, lines, crc32c "
                + "FROM journal WHERE image >= " + image + " ORDER BY id")) {
            while (row.next()) {
                long first = row.getLong(1);
                long last = row.getLong(2);
                byte[] lines = row.getBytes(3);
                if (lines == null || row.getLong(4) != checksum(lines, first, last)) {
                    problems.accept(file + ": the journal of the frames " + first + " to " + last
                            + " is damaged; the world resumes before them");
                    return;
                }
                into.add(new JournalRecord.Frames(first, last, lines));
            }
        }
    }

    /** Keeps the last images, and of the journal what follows the oldest of them. */
    private void dropOld() throws SQLException {
        try (Statement statement = connection.createStatement()) {
            statement.executeUpdate("DELETE FROM image WHERE id NOT IN "
                    + "(SELECT id FROM image ORDER BY id DESC LIMIT " + GENERATIONS + ")");
            statement.executeUpdate(
                    "DELETE FROM journal WHERE image < (SELECT min(id) FROM image)");
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

    private void closeAfter(Exception failure) {
        try {
            connection.close();
        } catch (SQLException e) {
            failure.addSuppressed(e);
        }
    }

    private IOException failed(String what, SQLException e) {
        return new IOException(file + " could not be " + what + ": " + e.getMessage(), e);
    }

    private static long number(Statement statement, String sql) throws SQLException {
        try (ResultSet result = statement.executeQuery(sql)) {
            return result.next() ? result.getLong(1) : 0;
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
