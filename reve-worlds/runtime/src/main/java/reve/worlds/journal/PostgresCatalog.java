// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.ResultSet;
import java.sql.SQLException;
import java.time.Duration;
import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.TreeMap;

/**
 * The list of the worlds of a database that several servers share, and the leases of these servers.
 * A catalog keeps one connection. The connection is opened at the first use, and again after a
 * failure. For any thread.
 */
public final class PostgresCatalog implements AutoCloseable {
    private static final int PATIENCE_SECONDS = 10;

    /** Maximum time for the last statement of a node that ends. */
    private static final Duration LEAVING = Duration.ofSeconds(3);

    /** Time after which the report of a lost node is removed [s]. */
    private static final int KEPT_SECONDS = 60;

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
     * @throws IOException if the database cannot be reached, or the user may create no tables
     */
    public void prepare() throws IOException {
        session.transaction("opened", PostgresTables::createForCluster);
    }

    /**
     * Returns the worlds of the database, by name.
     *
     * @throws IOException if the database cannot be reached
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
     * @throws IOException if the database cannot be reached
     */
    public boolean add(String world, Path pack) throws IOException {
        return add(world, pack, false);
    }

    /**
     * Adds a world like {@link #add(String, Path)}.
     *
     * @param isAsleep whether the world makes its first frame only when a client requests it
     */
    public boolean add(String world, Path pack, boolean isAsleep) throws IOException {
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
                    if (added > 0 && isAsleep) {
                        markAsleep(connection, world, 0);
                    }
                    return added > 0;
                });
    }

    /**
     * The orders of operators about the nodes that run worlds.
     *
     * @param nodes the node that shall run a world, by world
     * @param drained the nodes that shall run no worlds
     */
    public record Places(Map<String, String> nodes, Set<String> drained) {
        /** No orders. */
        public static final Places NONE = new Places(Map.of(), Set.of());

        /** Copies the collections. */
        public Places {
            nodes = Map.copyOf(nodes);
            drained = Set.copyOf(drained);
        }
    }

    /**
     * Returns the orders about the nodes that run worlds.
     *
     * @throws IOException if the database cannot be reached
     */
    public Places places() throws IOException {
        return session.run(
                "read",
                connection ->
                        PostgresSession.query(
                                connection,
                                "SELECT node, world FROM reve.place UNION ALL"
                                        + " SELECT node, NULL FROM reve.drained",
                                rows -> {
                                    Map<String, String> nodes = new HashMap<>();
                                    Set<String> drained = new HashSet<>();
                                    while (rows.next()) {
                                        String world = rows.getString(2);
                                        if (world == null) {
                                            drained.add(rows.getString(1));
                                        } else {
                                            nodes.put(world, rows.getString(1));
                                        }
                                    }
                                    return new Places(nodes, drained);
                                }));
    }

    /**
     * Returns the names of the worlds that sleep: no server runs them until a client requests them.
     *
     * @throws IOException if the database cannot be reached
     */
    public Set<String> asleep() throws IOException {
        return session.run(
                "read",
                connection ->
                        PostgresSession.query(
                                connection,
                                "SELECT name FROM reve.asleep JOIN reve.world ON name = world AND"
                                        + " reve.world.epoch = reve.asleep.epoch",
                                rows -> {
                                    Set<String> names = new HashSet<>();
                                    while (rows.next()) {
                                        names.add(rows.getString(1));
                                    }
                                    return Set.copyOf(names);
                                }));
    }

    /** Marks a world as asleep until a server takes it in a later epoch. */
    static void markAsleep(Connection connection, String world, long epoch) throws SQLException {
        PostgresSession.update(
                connection,
                "INSERT INTO reve.asleep VALUES (?, ?) ON CONFLICT (world) DO UPDATE SET epoch ="
                        + " excluded.epoch",
                world,
                epoch);
    }

    /**
     * The program of a node.
     *
     * @param version version of REVE, for people
     * @param protocol version of the data that nodes send to each other and store for each other
     * @param oldest oldest such version of another node that this program understands
     */
    public record Program(String version, int protocol, int oldest) {
        /** Returns whether each of the two programs understands the other. */
        boolean fits(Program other) {
            return protocol >= other.oldest && other.protocol >= oldest;
        }

        @Override
        public String toString() {
            return "REVE "
                    + version
                    + ", which speaks version "
                    + protocol
                    + " between nodes and understands "
                    + (oldest == protocol ? "no other one" : oldest + " to " + protocol);
        }
    }

    /**
     * The load of a node.
     *
     * @param web address of the node's web page; empty if it serves none
     * @param cpu share of its processors that the machine of the node uses, 0 to 1
     * @param memory share of its memory that the machine of the node uses, 0 to 1
     * @param clients number of connections of clients
     */
    public record Load(String web, double cpu, double memory, long clients) {}

    /** The last report of a node. */
    public record Report(Program program, Load load) {
        static Report read(ResultSet row) throws SQLException {
            return new Report(
                    new Program(row.getString(2), row.getInt(3), row.getInt(4)),
                    new Load(row.getString(5), row.getDouble(6), row.getDouble(7), row.getLong(8)));
        }
    }

    /**
     * Stores the first report of a node, if its program and those of all other nodes understand
     * each other. Other nodes are those that have reported within the duration of a lease.
     *
     * @throws IOException if a node has an incompatible program, or the database cannot be reached
     */
    public void enter(String node, Report report) throws IOException {
        session.transaction(
                "written",
                connection -> {
                    PostgresTables.lock(connection); // of nodes that start at once, one is first
                    Map<String, Report> others = reports(connection, PostgresStore.LEASE_SECONDS);
                    others.remove(node); // an earlier process at the same address
                    for (Map.Entry<String, Report> other : others.entrySet()) {
                        Program running = other.getValue().program();
                        if (!running.fits(report.program())) {
                            throw new IOException(
                                    "the node "
                                            + other.getKey()
                                            + " runs "
                                            + running
                                            + "; this program is "
                                            + report.program()
                                            + ". Start a version that fits, or end all other nodes"
                                            + " first");
                        }
                    }
                    return store(connection, node, report);
                });
    }

    /**
     * Stores the report of a node, and removes those of nodes that have not reported for a minute.
     *
     * @throws IOException if the database cannot be reached
     */
    public void report(String node, Report report) throws IOException {
        session.run("written", connection -> store(connection, node, report));
    }

    private static int store(Connection connection, String node, Report report)
            throws SQLException {
        Program program = report.program();
        Load load = report.load();
        return PostgresSession.update(
                connection,
                "WITH silent AS (DELETE FROM reve.node WHERE node <> ? AND reported <"
                        + " clock_timestamp() - interval '"
                        + KEPT_SECONDS
                        + " s') INSERT INTO reve.node VALUES (?,"
                        + " ?, ?, ?, ?, ?, ?, ?, clock_timestamp()) ON CONFLICT (node) DO UPDATE"
                        + " SET version = excluded.version, protocol = excluded.protocol, oldest ="
                        + " excluded.oldest, web = excluded.web, cpu = excluded.cpu, memory ="
                        + " excluded.memory, clients = excluded.clients, reported ="
                        + " excluded.reported",
                node,
                node,
                program.version(),
                program.protocol(),
                program.oldest(),
                load.web(),
                load.cpu(),
                load.memory(),
                load.clients());
    }

    /**
     * Returns the last reports of the nodes, also of nodes that were lost within a minute.
     *
     * @throws IOException if the database cannot be reached
     */
    public Map<String, Report> reports() throws IOException {
        return session.run("read", connection -> reports(connection, KEPT_SECONDS));
    }

    private static Map<String, Report> reports(Connection connection, int seconds)
            throws SQLException {
        return PostgresSession.query(
                connection,
                "SELECT node, version, protocol, oldest, web, cpu, memory, clients FROM reve.node"
                        + " WHERE reported > clock_timestamp() - ? * interval '1 s'",
                rows -> {
                    Map<String, Report> reports = new TreeMap<>();
                    while (rows.next()) {
                        reports.put(rows.getString(1), Report.read(rows));
                    }
                    return reports;
                },
                seconds);
    }

    /**
     * Removes the report of a node that ends. The catalog cannot be used afterwards.
     *
     * @throws IOException if the database cannot be reached
     */
    public void leave(String node) throws IOException {
        session.endWithin(LEAVING);
        session.run(
                "written",
                connection ->
                        PostgresSession.update(
                                connection, "DELETE FROM reve.node WHERE node = ?", node));
    }

    /**
     * Stores which node shall run a world.
     *
     * @param node empty if any node may run it
     * @throws IOException if the database cannot be reached; the order may then be stored
     */
    public void place(String world, Optional<String> node) throws IOException {
        session.run(
                "written",
                connection ->
                        node.isEmpty()
                                ? PostgresSession.update(
                                        connection, "DELETE FROM reve.place WHERE world = ?", world)
                                : PostgresSession.update(
                                        connection,
                                        "INSERT INTO reve.place VALUES (?, ?) ON CONFLICT (world)"
                                                + " DO UPDATE SET node = excluded.node",
                                        world,
                                        node.get()));
    }

    /**
     * Stores whether a node shall run no worlds.
     *
     * @throws IOException if the database cannot be reached; the order may then be stored
     */
    public void drain(String node, boolean isDrained) throws IOException {
        session.run(
                "written",
                connection ->
                        PostgresSession.update(
                                connection,
                                isDrained
                                        ? "INSERT INTO reve.drained VALUES (?) ON CONFLICT DO"
                                                + " NOTHING"
                                        : "DELETE FROM reve.drained WHERE node = ?",
                                node));
    }

    /**
     * Takes a lease, or extends it if the owner has it.
     *
     * @param owner the name of the owner, which differs from the names of all other owners
     * @param length time until the lease ends, by the clock of the database
     * @return false if another owner has the lease
     * @throws IOException if the database cannot be reached; the lease may have been taken
     *     nevertheless
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
     * @throws IOException if the database cannot be reached
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
     * @throws IOException if the database cannot be reached
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
