// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;
import org.postgresql.Driver;

import java.io.IOException;
import java.sql.Connection;
import java.sql.PreparedStatement;
import java.sql.ResultSet;
import java.sql.SQLException;
import java.sql.Statement;
import java.time.Duration;
import java.util.OptionalLong;
import java.util.Properties;
import java.util.logging.Level;
import java.util.logging.Logger;

/**
 * A connection to a database. It is opened at the first use. A lost connection is opened again at
 * the next use. For any thread; one thread at a time uses the connection.
 */
final class PostgresSession implements AutoCloseable {
    private static final int CONNECT_SECONDS = 5;
    private static final long NANOSECONDS_PER_SECOND = 1_000_000_000;

    /**
     * Limits of the database for this connection. The database ends a transaction whose client is
     * silent, so that a paused server does not keep a lock.
     */
    private static final String LIMITS =
            "SET lock_timeout = '10s'; SET idle_in_transaction_session_timeout = '5s';"
                    + " SET statement_timeout = '60s'; SET client_min_messages = warning";

    /** The driver's own log. Its exceptions contain the same text, and become our messages. */
    private static final Logger DRIVER_LOG = Logger.getLogger("org.postgresql");

    static {
        DRIVER_LOG.setLevel(Level.OFF);
    }

    private final PostgresUrl url;
    private final Properties properties;
    private final boolean flushes;
    private volatile @Nullable Connection connection;

    /** The time at which the session ends [ns]; empty while no end is set. */
    private volatile OptionalLong endNanos = OptionalLong.empty();

    /** A function that uses the connection. */
    interface Work<T> {
        T run(Connection connection) throws SQLException, IOException;
    }

    /**
     * Creates a session; connects at the first use.
     *
     * @param patienceSeconds maximum wait for an answer of the database [s]
     * @param flushes whether a commit waits until the disk of the database has the data
     */
    PostgresSession(PostgresUrl url, int patienceSeconds, boolean flushes) {
        this.url = url;
        this.flushes = flushes;
        properties = url.properties();
        properties.setProperty("connectTimeout", Integer.toString(CONNECT_SECONDS));
        properties.setProperty("loginTimeout", Integer.toString(CONNECT_SECONDS));
        properties.setProperty("socketTimeout", Integer.toString(patienceSeconds));
        properties.setProperty("tcpKeepAlive", "true");
        properties.setProperty("ApplicationName", "reve");
    }

    /**
     * Runs a single statement, which is a transaction by itself. The statement is run once more, on
     * a new connection, if a connection that was already open is lost. In this case the database
     * may have executed it twice.
     *
     * @param what the operation for messages, as a participle such as "read"
     * @throws IOException if the database refuses the statement or cannot be reached
     */
    synchronized <T> T run(String what, Work<T> work) throws IOException {
        return repeated(what, () -> work.run(open()));
    }

    /**
     * Runs work in a transaction. Either all of its changes take effect, or none. Like {@link
     * #run}, runs the work once more if the connection is lost.
     */
    synchronized <T> T transaction(String what, Work<T> work) throws IOException {
        return repeated(
                what,
                () -> {
                    Connection used = open();
                    used.setAutoCommit(false);
                    T result = work.run(used);
                    used.commit();
                    used.setAutoCommit(true);
                    return result;
                });
    }

    private interface Attempt<T> {
        T run() throws SQLException, IOException;
    }

    private <T> T repeated(String what, Attempt<T> attempt) throws IOException {
        boolean wasOpen = connection != null;
        try {
            return attempt(attempt);
        } catch (SQLException lost) {
            if (!wasOpen || !PostgresTrouble.isAway(lost)) {
                throw PostgresTrouble.of(url, what, lost);
            }
        }
        try {
            return attempt(attempt);
        } catch (SQLException e) {
            throw PostgresTrouble.of(url, what, e);
        }
    }

    private <T> T attempt(Attempt<T> attempt) throws SQLException, IOException {
        try {
            return attempt.run();
        } catch (SQLException | IOException | RuntimeException e) {
            drop(e);
            throw e;
        }
    }

    /** Ends the connection after a time, also during a statement. For any thread. */
    void endWithin(Duration limit) {
        endNanos = OptionalLong.of(System.nanoTime() + limit.toNanos());
        Thread.ofVirtual().name("end of a session").start(() -> abortAfter(limit));
    }

    private void abortAfter(Duration limit) {
        try {
            Thread.sleep(limit);
            Connection open = connection;
            if (open != null) {
                open.abort(Runnable::run);
            }
        } catch (InterruptedException | SQLException e) {
            // The exception is ignored, because the connection ends with the process at the latest.
        }
    }

    private Connection open() throws SQLException, IOException {
        Connection open = connection;
        if (open != null) {
            return open;
        }
        PasswordFile.check();
        OptionalLong end = endNanos;
        if (end.isPresent()) {
            long left = end.getAsLong() - System.nanoTime();
            if (left <= 0) {
                throw new SQLException("this server is ending", "57P01");
            }
            long seconds = Math.min(CONNECT_SECONDS, left / NANOSECONDS_PER_SECOND + 1);
            properties.setProperty("connectTimeout", Long.toString(seconds));
            properties.setProperty("loginTimeout", Long.toString(seconds));
        }
        Connection opened = new Driver().connect(url.forDriver(), properties);
        if (opened == null) {
            throw new SQLException("the driver does not accept the address " + url);
        }
        try (Statement statement = opened.createStatement()) {
            statement.execute(LIMITS + "; SET synchronous_commit = " + (flushes ? "on" : "off"));
        } catch (SQLException e) {
            connection = opened;
            drop(e);
            throw e;
        }
        connection = opened;
        return opened;
    }

    /** Closes the connection after a failure. The database then rolls back an open transaction. */
    private void drop(Exception failure) {
        Connection failed = connection;
        connection = null;
        if (failed != null) {
            try {
                failed.close();
            } catch (SQLException e) {
                failure.addSuppressed(e);
            }
        }
    }

    /** Executes a statement and returns the number of changed rows. */
    static int update(Connection connection, String sql, Object... values) throws SQLException {
        try (PreparedStatement statement = connection.prepareStatement(sql)) {
            set(statement, values);
            return statement.executeUpdate();
        }
    }

    /** A function that reads the rows of a query. */
    interface Reading<T> {
        T read(ResultSet rows) throws SQLException;
    }

    /** Executes a query and reads its rows. */
    static <T> T query(Connection connection, String sql, Reading<T> reading, Object... values)
            throws SQLException {
        try (PreparedStatement statement = connection.prepareStatement(sql)) {
            set(statement, values);
            try (ResultSet rows = statement.executeQuery()) {
                return reading.read(rows);
            }
        }
    }

    private static void set(PreparedStatement statement, Object... values) throws SQLException {
        for (int i = 0; i < values.length; i++) {
            statement.setObject(i + 1, values[i]);
        }
    }

    @Override
    public synchronized void close() throws IOException {
        Connection open = connection;
        connection = null;
        if (open != null) {
            try {
                open.close();
            } catch (SQLException e) {
                throw PostgresTrouble.of(url, "closed", e);
            }
        }
    }
}
