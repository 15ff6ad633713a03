// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Optional;

/**
 * The list of the worlds of a database that several servers share, and the leases of these servers.
 * A catalog keeps one connection, which it opens at the first use, and again after a failure. For
 * any thread.
 */
public final class PostgresCatalog implements AutoCloseable {
    private static final int PATIENCE_SECONDS = 10;

    private static final String LEASES =
            "CREATE TABLE IF NOT EXISTS reve.lease (name text PRIMARY KEY, owner text NOT NULL,"
                    + " lease_until timestamptz NOT NULL)";

    private static final String TAKE =
            "INSERT INTO reve.lease AS known VALUES (?, ?, clock_timestamp() + ? * interval '1 ms')"
                    + " ON CONFLICT (name) DO UPDATE SET owner = excluded.owner,"
                    + " lease_until = excluded.lease_until WHERE known.owner = excluded.owner"
                    + " OR known.lease_until <= clock_timestamp()";

    private final PostgresSession session;

    /** Creates a catalog; connects at the first use. */
    public PostgresCatalog(PostgresUrl url) {
        session = new PostgresSession(url, PATIENCE_SECONDS, true);
    }

    /**
     * Creates the tables that the database lacks.
     *
     * @throws reve.core.image.CorruptException if the tables have another version
     * @throws IOException if the database is away, or the user may create no tables
     */
    public void prepare() throws IOException {
        session.transaction("opened", PostgresStore::createTables);
        session.transaction(
                "opened",
                connection -> {
                    boolean isThere =
                            PostgresSession.query(
                                    connection,
                                    "SELECT to_regclass('reve.lease') IS NOT NULL",
                                    rows -> rows.next() && rows.getBoolean(1));
                    if (!isThere) {
                        PostgresSession.query(
                                connection,
                                "SELECT pg_advisory_xact_lock(?)",
                                rows -> rows.next(),
                                PostgresStore.CREATION_LOCK);
                        PostgresSession.update(connection, LEASES);
                    }
                    return isThere;
                });
    }

    /**
     * Returns the worlds of the database, by name.
     *
     * @throws IOException if the database is away
     */
    public List<PostgresStore.World> worlds() throws IOException {
        return session.run("read", PostgresStore::worlds);
    }

    /**
     * Adds a world that has made no frames. Changes nothing if the database has a world of this
     * name.
     *
     * @param pack file with the world and all files that it needs
     * @return whether the world was added
     * @throws IOException if the database is away
     */
    public boolean add(String world, Path pack) throws IOException {
        byte[] bytes = Files.readAllBytes(pack);
        return session.transaction(
                "written",
                connection -> {
                    int added =
                            PostgresSession.update(
                                    connection,
                                    "INSERT INTO reve.world VALUES (?, 0, '', clock_timestamp(),"
                                            + " -1, '') ON CONFLICT (name) DO NOTHING",
                                    world);
                    if (added > 0) {
                        PostgresSession.update(
                                connection,
                                "INSERT INTO reve.pack VALUES (?, 0, ?, ?)",
                                world,
                                StoreDatabase.sha256(bytes),
                                bytes);
                    }
                    return added > 0;
                });
    }

    /**
     * Takes a lease, or extends it if the owner has it.
     *
     * @param owner the name of the owner, which differs from the names of all other owners
     * @param length time until the lease ends, by the clock of the database
     * @return false if another owner has the lease
     * @throws IOException if the database is away; the owner may then have the lease
     */
    public boolean takeLease(String lease, String owner, Duration length) throws IOException {
        return session.run(
                "written",
                connection ->
                        PostgresSession.update(connection, TAKE, lease, owner, length.toMillis())
                                == 1);
    }

    /**
     * Returns the end of a lease by the clock of the database, as a text; empty if it has no owner.
     *
     * @throws IOException if the database is away
     */
    public Optional<String> leaseEnd(String lease) throws IOException {
        return session.run(
                "read",
                connection ->
                        PostgresSession.query(
                                connection,
                                "SELECT lease_until::text FROM reve.lease WHERE name = ? AND"
                                        + " lease_until > clock_timestamp()",
                                rows ->
                                        rows.next()
                                                ? Optional.of(rows.getString(1))
                                                : Optional.<String>empty(),
                                lease));
    }

    /**
     * Ends a lease of an owner. Does nothing if the owner does not have it.
     *
     * @throws IOException if the database is away
     */
    public void endLease(String lease, String owner) throws IOException {
        session.run(
                "written",
                connection ->
                        PostgresSession.update(
                                connection,
                                "DELETE FROM reve.lease WHERE name = ? AND owner = ?",
                                lease,
                                owner));
    }

    /** Disconnects. Idempotent. */
    @Override
    public void close() throws IOException {
        session.close();
    }
}
