// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.sqlite.SQLiteConfig;
import org.sqlite.SQLiteConnection;
import org.sqlite.SQLiteErrorCode;
import org.sqlite.SQLiteLimits;

import reve.core.image.CorruptException;
import reve.worlds.Product;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.sql.Connection;
import java.sql.ResultSet;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.LinkedHashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.UUID;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.stream.Collectors;
import java.util.zip.CRC32C;

/**
 * The SQLite database of a store. This class contains its schema and the queries that do not change
 * any byte of it.
 */
final class StoreDatabase {
    /** Number in SQLite's header that identifies the application; its bytes are "REVE" in ASCII. */
    static final int APPLICATION_ID = 0x52455645;

    static final int VERSION = 3;

    /**
     * Version of stores without an identity. Such a store receives an identity at the next write.
     */
    private static final int OLD_VERSION = 2;

    private static final String LIBRARY =
            "CREATE TABLE library (sha256 TEXT PRIMARY KEY, bytes BLOB NOT NULL)";
    private static final String IMAGE =
            """
            CREATE TABLE image (frames_file INTEGER PRIMARY KEY, frame INTEGER NOT NULL,
                bytes BLOB NOT NULL, crc32c INTEGER NOT NULL)\
            """;
    private static final String IDENTITY = "identity (id TEXT NOT NULL, since INTEGER NOT NULL)";
    static final String IDENTITY_IF_ABSENT = "CREATE TABLE IF NOT EXISTS " + IDENTITY;

    /** Schema of version 2 as SQLite reports it, including the index of a primary key. */
    private static final Set<Element> OLD_SCHEMA =
            Set.of(
                    new Element("table", "library", "library", LIBRARY),
                    new Element(
                            "index", "sqlite_autoindex_library_1", "library", Element.AUTOMATIC),
                    new Element("table", "image", "image", IMAGE));

    private static final Element IDENTITY_TABLE =
            new Element("table", "identity", "identity", "CREATE TABLE " + IDENTITY);

    /** Maximum length of an SQL statement, including those in a schema [bytes]. */
    private static final int SQL_BYTES = 1_000;

    /** Maximum length of a name in a message [characters]. */
    private static final int NAME_LENGTH = 60;

    /**
     * System property that names the folder of SQLite's native library. The driver unpacks the
     * library to a temporary file if this property is not set.
     */
    private static final String LIBRARY_FOLDER = "org.sqlite.lib.path";

    static {
        if (System.getProperty(LIBRARY_FOLDER) == null) {
            System.setProperty(LIBRARY_FOLDER, Product.nativeFolder().toAbsolutePath().toString());
        }
    }

    private StoreDatabase() {}

    /**
     * The identity of a store.
     *
     * @param since number of the first file of frames that contains the identity
     */
    record Identity(UUID id, long since) {}

    /** A row of an image in the database, without the image's bytes. */
    record ImageRow(long framesFile, long frame, long sum, boolean isGood) {}

    /**
     * The readable rows of the database.
     *
     * @param isIdentified whether stores of this version have an identity
     * @param images newest first
     * @param libraries the libraries, by the SHA-256 of their actual bytes
     * @param damagedLibraries expected SHA-256 of libraries whose bytes have a different SHA-256
     */
    record Rows(
            boolean isIdentified,
            Optional<Identity> identity,
            List<ImageRow> images,
            Map<String, byte[]> libraries,
            List<String> damagedLibraries,
            List<String> damage) {
        static final Rows NONE =
                new Rows(true, Optional.empty(), List.of(), Map.of(), List.of(), List.of());
    }

    /** An element of a database schema. */
    private record Element(String type, String name, String table, String sql) {
        /** Placeholder for the SQL of elements that SQLite creates itself. */
        private static final String AUTOMATIC = "null";

        private boolean isSame(Element other) {
            return type.equals(other.type) && name.equals(other.name);
        }

        @Override
        public String toString() {
            String all = type + " " + name;
            return all.length() > NAME_LENGTH ? all.substring(0, NAME_LENGTH) + "..." : all;
        }
    }

    private interface Query {
        void run(Statement statement) throws SQLException;
    }

    static Rows read(Path file) throws IOException {
        requireMark(file);
        List<ImageRow> images = new ArrayList<>();
        Map<String, byte[]> libraries = new LinkedHashMap<>();
        List<String> damagedLibraries = new ArrayList<>();
        List<String> damage = new ArrayList<>();
        List<Identity> identity = new ArrayList<>();
        var isIdentified = new AtomicBoolean();
        var isBlank = new AtomicBoolean();
        reading(
                file,
                statement -> {
                    if (isBlank(statement)) {
                        isBlank.set(true);
                        return;
                    }
                    isIdentified.set(check(file, statement, damage));
                    attempt(
                            file,
                            damage,
                            () -> readLibraries(statement, libraries, damagedLibraries));
                    attempt(file, damage, () -> readImages(statement, images));
                    if (isIdentified.get()) {
                        attempt(file, damage, () -> readIdentity(statement, identity));
                    }
                });
        if (isBlank.get()) {
            return Rows.NONE;
        }
        return new Rows(
                isIdentified.get(),
                identity.stream().findFirst(),
                images,
                libraries,
                damagedLibraries,
                damage);
    }

    /** Reads the image of a row that is not damaged. */
    static JournalRecord.Image image(Path file, ImageRow row) throws IOException {
        List<JournalRecord.Image> found = new ArrayList<>();
        reading(
                file,
                statement -> {
                    try (ResultSet result =
                            statement.executeQuery(
                                    "SELECT bytes FROM image WHERE frames_file = "
                                            + row.framesFile())) {
                        result.next();
                        found.add(new JournalRecord.Image(row.frame(), result.getBytes(1)));
                    }
                });
        return found.getFirst();
    }

    /** Opens a connection for writing; creates the tables of an empty database. */
    static Connection open(Path file) throws IOException {
        SQLiteConfig config = new SQLiteConfig();
        config.setLockingMode(SQLiteConfig.LockingMode.EXCLUSIVE);
        config.setBusyTimeout(0);
        Connection opened;
        try {
            opened = config.createConnection("jdbc:sqlite:" + file.toAbsolutePath());
        } catch (SQLException e) {
            throw FileTrouble.of(file, "opened", e);
        }
        try (Statement statement = opened.createStatement()) {
            restrict(opened, statement);
            // The exclusive lock is set first. WAL mode then needs no file for shared memory
            // (-shm).
            statement.execute("PRAGMA journal_mode = WAL");
            statement.execute("PRAGMA synchronous = FULL");
            // One transaction makes all changes or none, even if the process is killed.
            opened.setAutoCommit(false);
            boolean isNew = isBlank(statement);
            if (isNew) {
                statement.executeUpdate("PRAGMA application_id = " + APPLICATION_ID);
                for (String table : List.of(LIBRARY, IMAGE, IDENTITY_IF_ABSENT)) {
                    statement.executeUpdate(table);
                }
            }
            long version = isNew ? VERSION : number(statement, "PRAGMA user_version");
            // The first write locks the file.
            statement.executeUpdate("PRAGMA user_version = " + version);
            opened.commit();
            return opened;
        } catch (SQLException e) {
            closeAfter(opened, e);
            throw FileTrouble.of(file, "opened", e);
        }
    }

    /** Returns whether a database has no content, because its creation was interrupted. */
    private static boolean isBlank(Statement statement) throws SQLException {
        return number(statement, "SELECT count(*) FROM sqlite_schema") == 0
                && number(statement, "PRAGMA application_id") == 0
                && number(statement, "PRAGMA user_version") == 0;
    }

    static void closeAfter(Connection connection, Exception failure) {
        try {
            connection.close();
        } catch (SQLException e) {
            failure.addSuppressed(e);
        }
    }

    /** Returns the paths of the files that SQLite creates beside the database. */
    static List<Path> besides(Path file) {
        return List.of(
                file.resolveSibling(file.getFileName() + "-wal"),
                file.resolveSibling(file.getFileName() + "-shm"));
    }

    /** Returns the path of the rollback journal, which SQLite applies when it opens a database. */
    static Path rollback(Path file) {
        return file.resolveSibling(file.getFileName() + "-journal");
    }

    static long number(Statement statement, String sql) throws SQLException {
        try (ResultSet result = statement.executeQuery(sql)) {
            return result.next() ? result.getLong(1) : 0;
        }
    }

    static long checksum(byte[] bytes, long... numbers) {
        var crc = new CRC32C();
        for (long number : numbers) {
            crc.update(ByteBuffer.allocate(Long.BYTES).putLong(number).flip());
        }
        crc.update(bytes);
        return crc.getValue();
    }

    /**
     * Runs a query on a read-only connection, because other connections change the write-ahead log.
     * SQLite nevertheless creates files beside the database; this method removes them. A store
     * whose creation was interrupted has a rollback journal, and SQLite must write to the database
     * to apply it.
     */
    private static void reading(Path file, Query query) throws IOException {
        List<Path> made =
                besides(file).stream()
                        .filter(beside -> !Files.exists(beside, LinkOption.NOFOLLOW_LINKS))
                        .toList();
        SQLiteConfig config = new SQLiteConfig();
        config.setReadOnly(!Files.isRegularFile(rollback(file), LinkOption.NOFOLLOW_LINKS));
        config.setBusyTimeout(0);
        try (Connection connection =
                        config.createConnection("jdbc:sqlite:" + file.toAbsolutePath());
                Statement statement = connection.createStatement()) {
            restrict(connection, statement);
            query.run(statement);
        } catch (SQLException e) {
            throw unreadable(file, e);
        } finally {
            for (Path beside : made) {
                Files.deleteIfExists(beside);
            }
        }
    }

    /**
     * Forbids functions and attached databases, because the file and its schema may come from an
     * untrusted author.
     */
    private static void restrict(Connection connection, Statement statement) throws SQLException {
        var limited = connection.unwrap(SQLiteConnection.class);
        limited.setLimit(SQLiteLimits.SQLITE_LIMIT_ATTACHED, 0);
        limited.setLimit(SQLiteLimits.SQLITE_LIMIT_SQL_LENGTH, SQL_BYTES);
        statement.execute("PRAGMA trusted_schema = OFF");
        statement.execute("PRAGMA cell_size_check = ON");
    }

    private static IOException unreadable(Path file, SQLException e) {
        SQLiteErrorCode code = SQLiteErrorCode.getErrorCode(e.getErrorCode() & 0xff);
        if (code == SQLiteErrorCode.SQLITE_CORRUPT
                || code == SQLiteErrorCode.SQLITE_NOTADB
                || code == SQLiteErrorCode.SQLITE_TOOBIG) {
            throw new CorruptException(
                    file
                            + " is damaged so that nothing of it can be read ("
                            + e.getMessage()
                            + "); put a copy of it and its files in its place, or name "
                            + "another file",
                    e);
        }
        return FileTrouble.of(file, "opened", e);
    }

    private interface Reading {
        void run() throws SQLException;
    }

    private static void attempt(Path file, List<String> damage, Reading reading)
            throws SQLException {
        try {
            reading.run();
        } catch (SQLException e) {
            if (e.getErrorCode() == SQLiteErrorCode.SQLITE_BUSY.code) {
                throw e;
            }
            damage.add(file + " is damaged: " + e.getMessage());
        }
    }

    private static boolean check(Path file, Statement statement, List<String> damage)
            throws SQLException {
        if (number(statement, "PRAGMA application_id") != APPLICATION_ID) {
            throw new CorruptException(
                    file + " is an SQLite database but no store of REVE;" + " name another file");
        }
        long version = number(statement, "PRAGMA user_version");
        if (version != VERSION && version != OLD_VERSION) {
            throw new CorruptException(
                    file
                            + " is a store of version "
                            + version
                            + ", this program reads and writes "
                            + VERSION);
        }
        requireSchema(file, statement, version);
        attempt(
                file,
                damage,
                () -> {
                    try (ResultSet result = statement.executeQuery("PRAGMA integrity_check(1)")) {
                        String found = result.next() ? result.getString(1) : "nothing";
                        if (!found.equals("ok")) {
                            damage.add(file + " is damaged: " + found.replace('\n', ' '));
                        }
                    }
                });
        return version == VERSION;
    }

    /**
     * Throws an exception if the schema differs from the expected one. A view, trigger, check or
     * generated column would run SQL of an untrusted author. Such SQL may run for ever, or show
     * data that is not stored.
     */
    private static void requireSchema(Path file, Statement statement, long version)
            throws SQLException {
        Set<Element> expected = new LinkedHashSet<>(OLD_SCHEMA);
        if (version == VERSION) {
            expected.add(IDENTITY_TABLE);
        }
        Set<Element> found = new LinkedHashSet<>();
        try (ResultSet row =
                statement.executeQuery(
                        "SELECT type, name, tbl_name, sql "
                                + "FROM sqlite_schema LIMIT "
                                + (expected.size() + 1))) {
            while (row.next()) {
                found.add(
                        new Element(
                                String.valueOf(row.getString(1)),
                                String.valueOf(row.getString(2)),
                                String.valueOf(row.getString(3)),
                                String.valueOf(row.getString(4))));
            }
        }
        for (Element each : found) {
            if (!expected.contains(each)) {
                throw otherSchema(
                        file,
                        "has a "
                                + each
                                + (expected.stream().anyMatch(each::isSame)
                                        ? " of another form"
                                        : ""),
                        expected);
            }
        }
        for (Element each : expected) {
            if (!found.contains(each)) {
                throw otherSchema(file, "lacks the " + each, expected);
            }
        }
    }

    private static CorruptException otherSchema(Path file, String what, Set<Element> expected) {
        return new CorruptException(
                file
                        + " "
                        + what
                        + ", expected only the tables "
                        + expected.stream()
                                .filter(each -> each.type.equals("table"))
                                .map(Element::name)
                                .sorted()
                                .collect(Collectors.joining(", "))
                        + " as this program makes them: another program changed it, or it is"
                        + " damaged; put a copy of it and its files in its place, or name another"
                        + " file (nothing was changed)");
    }

    private static void readLibraries(
            Statement statement, Map<String, byte[]> into, List<String> damaged)
            throws SQLException {
        try (ResultSet row = statement.executeQuery("SELECT sha256, bytes FROM library")) {
            while (row.next()) {
                byte[] bytes = row.getBytes(2);
                String found = sha256(bytes == null ? new byte[0] : bytes);
                if (!found.equals(row.getString(1))) {
                    damaged.add(row.getString(1));
                }
                into.put(found, bytes == null ? new byte[0] : bytes);
            }
        }
    }

    private static void readImages(Statement statement, List<ImageRow> into) throws SQLException {
        try (ResultSet row =
                statement.executeQuery(
                        "SELECT frames_file, frame, bytes, crc32c FROM image ORDER BY frames_file"
                                + " DESC")) {
            while (row.next()) {
                byte[] bytes = row.getBytes(3);
                long sum = row.getLong(4);
                into.add(
                        new ImageRow(
                                row.getLong(1),
                                row.getLong(2),
                                sum,
                                bytes != null
                                        && sum == checksum(bytes, row.getLong(1), row.getLong(2))));
            }
        }
    }

    private static void readIdentity(Statement statement, List<Identity> into) throws SQLException {
        try (ResultSet row = statement.executeQuery("SELECT id, since FROM identity")) {
            if (row.next()) {
                try {
                    into.add(new Identity(UUID.fromString(row.getString(1)), row.getLong(2)));
                } catch (IllegalArgumentException e) {
                    throw new SQLException("its identity makes no sense: " + e.getMessage(), e);
                }
            }
        }
    }

    private static void requireMark(Path file) throws IOException {
        try (var in = Files.newInputStream(file)) {
            if (!new String(in.readNBytes(16), StandardCharsets.ISO_8859_1)
                    .equals("SQLite format 3\0")) {
                throw new CorruptException(
                        file
                                + " is no store of REVE, or damaged so that nothing"
                                + " of it can be read; name another file, or put back a copy");
            }
        } catch (IOException e) {
            throw FileTrouble.of(file, "opened", e);
        }
    }

    static String sha256(byte[] bytes) {
        try {
            return HexFormat.of().formatHex(MessageDigest.getInstance("SHA-256").digest(bytes));
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }
}
