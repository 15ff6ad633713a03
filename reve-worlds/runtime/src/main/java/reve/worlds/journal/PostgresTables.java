// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.image.CorruptException;

import java.io.IOException;
import java.sql.Connection;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.List;
import java.util.Optional;

/**
 * The tables of a database that several servers share, and their version. Servers create them. The
 * version changes if earlier programs cannot use the tables any more. A table or column that
 * earlier programs do not need is added without a new version.
 */
final class PostgresTables {
    /** Version of the tables that this program reads and writes. */
    private static final int VERSION = 1;

    /** Key of the lock under which tables are created and nodes enter ("REVE"). */
    private static final long LOCK = 0x52455645L;

    /** Maximum wait for an answer while a world is read [s]. */
    private static final int PATIENCE_SECONDS = 60;

    private static final List<String> TABLES =
            List.of(
                    "CREATE SCHEMA IF NOT EXISTS reve",
                    "CREATE TABLE reve.version (version integer NOT NULL)",
                    "INSERT INTO reve.version VALUES (" + VERSION + ")",
                    // half-filled pages have room for the new version of a row after each frame
                    """
                    CREATE TABLE reve.world (name text PRIMARY KEY, epoch bigint NOT NULL,
                        owner text NOT NULL, lease_until timestamptz NOT NULL,
                        frame bigint NOT NULL, agents text NOT NULL) WITH (fillfactor = 50)
                    """,
                    """
                    CREATE TABLE reve.pack (world text PRIMARY KEY, epoch bigint NOT NULL,
                        sha256 text NOT NULL, bytes bytea NOT NULL)
                    """,
                    """
                    CREATE TABLE reve.library (world text, sha256 text, epoch bigint NOT NULL,
                        bytes bytea NOT NULL, PRIMARY KEY (world, sha256))
                    """,
                    """
                    CREATE TABLE reve.image (world text, epoch bigint, number bigint,
                        frame bigint NOT NULL, bytes bytea NOT NULL, crc32c bigint NOT NULL,
                        PRIMARY KEY (world, epoch, number))
                    """,
                    """
                    CREATE TABLE reve.frame (world text, image bigint, frame bigint, epoch bigint,
                        bytes bytea NOT NULL, crc32c bigint NOT NULL,
                        PRIMARY KEY (world, image, frame, epoch))
                    """);

    /** The tables of clusters. */
    private static final List<String> TABLES_OF_CLUSTERS =
            List.of(
                    """
                    CREATE TABLE IF NOT EXISTS reve.lease (name text PRIMARY KEY,
                        owner text NOT NULL, lease_until timestamptz NOT NULL)
                    """,
                    """
                    CREATE TABLE IF NOT EXISTS reve.place (world text PRIMARY KEY,
                        node text NOT NULL)
                    """,
                    "CREATE TABLE IF NOT EXISTS reve.drained (node text PRIMARY KEY)",
                    // a world sleeps while its row has its epoch, so taking the world wakes it
                    """
                    CREATE TABLE IF NOT EXISTS reve.asleep (world text PRIMARY KEY,
                        epoch bigint NOT NULL)
                    """,
                    """
                    CREATE TABLE IF NOT EXISTS reve.node (node text PRIMARY KEY,
                        version text NOT NULL, protocol integer NOT NULL, oldest integer NOT NULL,
                        web text NOT NULL, cpu float8 NOT NULL, memory float8 NOT NULL,
                        clients bigint NOT NULL, reported timestamptz NOT NULL)
                    """,
                    CarriedSessions.TABLE,
                    NotedSessions.TABLE,
                    // images first, as in the transactions of images, which would wait otherwise
                    "ALTER TABLE reve.image ADD COLUMN IF NOT EXISTS notes bigint",
                    "ALTER TABLE reve.frame ADD COLUMN IF NOT EXISTS notes bigint");

    private static final String HAS_TABLES_OF_CLUSTERS =
            "SELECT to_regclass('reve.lease') IS NOT NULL AND to_regclass('reve.place') IS NOT NULL"
                    + " AND to_regclass('reve.drained') IS NOT NULL"
                    + " AND to_regclass('reve.asleep') IS NOT NULL"
                    + " AND to_regclass('reve.node') IS NOT NULL"
                    + " AND to_regclass('reve.session') IS NOT NULL AND "
                    + NotedSessions.ARE_KEPT;

    private PostgresTables() {}

    /**
     * Returns the version of the tables; empty if there are none.
     *
     * @throws CorruptException if this program cannot use tables of this version
     */
    static Optional<Integer> requireVersion(Connection connection) throws SQLException {
        if (!isTrue(connection, "SELECT to_regclass('reve.version') IS NOT NULL")) {
            return Optional.empty();
        }
        int version =
                PostgresSession.query(
                        connection,
                        "SELECT version FROM reve.version",
                        rows -> rows.next() ? rows.getInt(1) : 0);
        if (version != VERSION) {
            throw new CorruptException(
                    "the tables of the database "
                            + connection.getCatalog()
                            + " have the version "
                            + version
                            + ", this program reads and writes "
                            + VERSION
                            + "; use the version of REVE with which they were written, or another"
                            + " database");
        }
        return Optional.of(version);
    }

    /** Creates the tables in a database that has none; returns whether it did. */
    static boolean create(Connection connection) throws SQLException {
        if (requireVersion(connection).isPresent()) {
            return false;
        }
        lock(connection);
        if (requireVersion(connection).isPresent()) {
            return false;
        }
        execute(connection, TABLES);
        return true;
    }

    /**
     * Creates all tables that the database lacks, including those of clusters; returns whether it
     * did.
     */
    static boolean createForCluster(Connection connection) throws SQLException {
        boolean isNew = create(connection);
        if (isTrue(connection, HAS_TABLES_OF_CLUSTERS)) {
            return isNew;
        }
        lock(connection);
        execute(connection, TABLES_OF_CLUSTERS);
        return true;
    }

    /**
     * Acquires the lock for the rest of the transaction. Waits while another transaction holds it.
     */
    static void lock(Connection connection) throws SQLException {
        PostgresSession.query(
                connection, "SELECT pg_advisory_xact_lock(?)", rows -> rows.next(), LOCK);
    }

    /**
     * Reads a database in one transaction.
     *
     * @param none the result if the database has no tables
     */
    static <T> T reading(PostgresUrl url, T none, PostgresSession.Work<T> work) throws IOException {
        try (PostgresSession session = new PostgresSession(url, PATIENCE_SECONDS, true)) {
            boolean hasTables =
                    session.run("read", connection -> requireVersion(connection).isPresent());
            return hasTables ? session.transaction("read", work) : none;
        }
    }

    private static boolean isTrue(Connection connection, String query) throws SQLException {
        return PostgresSession.query(connection, query, rows -> rows.next() && rows.getBoolean(1));
    }

    private static void execute(Connection connection, List<String> statements)
            throws SQLException {
        try (Statement statement = connection.createStatement()) {
            for (String each : statements) {
                statement.execute(each);
            }
        }
    }
}
