// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.image.CorruptException;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.security.SecureRandom;
import java.sql.Connection;
import java.sql.ResultSet;
import java.sql.SQLException;
import java.sql.Statement;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.concurrent.atomic.AtomicLong;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;

/**
 * A world in a PostgreSQL database that several servers share. A server takes the world and is
 * granted an epoch, a number that grows with each grant. The row of the world also contains the
 * owner, a text that no other server has, because an epoch is granted again after the database was
 * restored from a backup. Each write of the server compares its epoch and itself with the row, in
 * the same transaction. After another server has taken the world, each write therefore fails with a
 * {@link JournalSink.LostException}. For the threads of a journal.
 */
public final class PostgresStore implements JournalSink {
    private static final int VERSION = 1;
    private static final int GENERATIONS = 3;

    /** Key of the lock under which the tables are created ("REVE"). */
    static final long CREATION_LOCK = 0x52455645L;

    /** Time for which a write keeps other servers from taking the world. */
    private static final String LEASE = "interval '10 s'"; // LEASE_SECONDS

    private static final int LEASE_SECONDS = 10;
    private static final long LEASE_NANOSECONDS = LEASE_SECONDS * 1_000_000_000L;

    /** Time without a write after which the lease is extended [ns]. */
    private static final long RENEWAL_NANOSECONDS = 2_000_000_000L;

    /** Interval between two attempts to take a world whose lease has not ended [ns]. */
    private static final long ATTEMPT_NANOSECONDS = 250_000_000L;

    private static final int FRAME_PATIENCE_SECONDS = 10;
    private static final int IMAGE_PATIENCE_SECONDS = 60;

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

    private static final String GRANT =
            "INSERT INTO reve.world AS known VALUES (?, 1, ?, clock_timestamp() + "
                    + LEASE
                    + ", -1, '') ON CONFLICT (name) DO UPDATE SET epoch = known.epoch + 1,"
                    + " owner = excluded.owner, lease_until = excluded.lease_until, agents = ''"
                    + " WHERE known.lease_until <= clock_timestamp() OR known.lease_until::text = ?"
                    + " RETURNING epoch";

    private static final String OWNED =
            "UPDATE reve.world SET frame = greatest(frame, ?), lease_until = clock_timestamp() + "
                    + LEASE
                    + " WHERE name = ? AND epoch = ? AND owner = ?";

    /**
     * Adds the frame that follows the last one. This is a single statement, so that the database
     * keeps no lock while it waits for this process.
     */
    private static final String ADD_FRAME =
            "WITH owned AS ("
                    + OWNED
                    + " AND frame = ? RETURNING name, epoch) INSERT INTO reve.frame"
                    + " SELECT name, ?, ?, epoch, ?, ? FROM owned";

    private static final String ADD_LIBRARY =
            "WITH owned AS ("
                    + OWNED
                    + " RETURNING name, epoch) INSERT INTO reve.library"
                    + " SELECT name, ?, epoch, ? FROM owned ON CONFLICT (world, sha256)"
                    + " DO UPDATE SET bytes = excluded.bytes, epoch = excluded.epoch";

    private static final String WORLDS =
            "SELECT name, epoch, owner, lease_until > clock_timestamp(), frame, agents,"
                    + " lease_until::text FROM reve.world";

    private static final String RELEASE =
            "UPDATE reve.world SET lease_until = clock_timestamp() WHERE name = ? AND epoch = ?"
                    + " AND owner = ?";

    private static final SecureRandom RANDOM = new SecureRandom();

    private final StoreAddress.InDatabase address;
    private final String world;

    /** This server and this use of the world, as the row of the world names them. */
    private final String self = thisServer();

    /** Writes frames and extends the lease. */
    private final PostgresSession frames;

    /** Writes images, so that frames do not wait for them. */
    private final PostgresSession images;

    private final Object loss = new Object();
    private long epoch;
    private volatile @Nullable PostgresContents contents;
    private volatile long image;
    private final AtomicLong reached = new AtomicLong(-1);
    private volatile long confirmedNanos;
    private volatile boolean closed;
    private volatile @Nullable LostException lost;
    private Consumer<String> lostListener = _ -> {};
    private volatile boolean toldAway;

    /**
     * The owner of a world and the end of its lease. A later end shows that the owner extends the
     * lease.
     */
    private record Owner(long epoch, String name, String until, double seconds) {
        private boolean isStill(Owner before) {
            return epoch == before.epoch && until.equals(before.until);
        }
    }

    /**
     * A world of a database.
     *
     * @param epoch number of times that servers have taken the world
     * @param owner the server that took it last
     * @param isOwned whether the lease of this server has not ended
     * @param frame newest acknowledged frame; -1 for none
     * @param agents host and port at which agents reach the world; empty if no server is ready
     * @param lease end of the lease by the clock of the database, as a text
     */
    public record World(
            String name,
            long epoch,
            String owner,
            boolean isOwned,
            long frame,
            String agents,
            String lease) {
        static World read(ResultSet row) throws SQLException {
            boolean isOwned = row.getBoolean(4);
            return new World(
                    row.getString(1),
                    row.getLong(2),
                    row.getString(3),
                    isOwned,
                    row.getLong(5),
                    isOwned ? row.getString(6) : "",
                    row.getString(7));
        }
    }

    private PostgresStore(StoreAddress.InDatabase address, SqliteStore.Durability durability) {
        this.address = address;
        world = address.world();
        frames =
                new PostgresSession(
                        address.url(),
                        FRAME_PATIENCE_SECONDS,
                        durability == SqliteStore.Durability.FULL);
        images = new PostgresSession(address.url(), IMAGE_PATIENCE_SECONDS, true);
    }

    /**
     * Takes a world. Creates the tables in a database that has none. Waits until the lease of the
     * present owner ends.
     *
     * @param problems receives a message while this method waits
     * @throws IOException if the database cannot be reached, or another server extends its lease
     */
    static TakenStore take(
            StoreAddress.InDatabase address,
            SqliteStore.Durability durability,
            Consumer<String> problems)
            throws IOException {
        PostgresStore store = new PostgresStore(address, durability);
        try {
            store.images.transaction("opened", PostgresStore::createTables);
            store.epoch = store.grant(problems);
            store.confirmedNanos = System.nanoTime();
            // Reading a large world may take longer than the lease.
            Thread.ofVirtual().name("lease of " + store.world).start(store::extendLease);
            PostgresContents read =
                    store.images.transaction(
                            "read",
                            connection ->
                                    PostgresContents.read(
                                            connection, address.toString(), address.world()));
            store.contents = read;
            store.image = read.lastImage();
            store.reached.set(read.frame());
            store.requireNotLost();
        } catch (IOException | RuntimeException refused) {
            store.closeAfter(refused);
            throw refused;
        }
        return store.taken();
    }

    private TakenStore taken() {
        return new TakenStore() {
            private boolean opened;

            @Override
            public StoreReading contents() {
                return read();
            }

            @Override
            public OptionalLong epoch() {
                return OptionalLong.of(epoch);
            }

            @Override
            public JournalSink open() throws IOException {
                storePack();
                opened = true;
                contents = null; // an image may be large
                return PostgresStore.this;
            }

            @Override
            public void close() {
                if (!opened) {
                    closeAfter(new IOException("not opened"));
                }
            }
        };
    }

    private PostgresContents read() {
        PostgresContents now = contents;
        if (now == null) {
            throw new IllegalStateException("the content of " + address + " was released");
        }
        return now;
    }

    private void closeAfter(Exception failure) {
        try {
            close();
        } catch (IOException e) {
            failure.addSuppressed(e);
        }
    }

    /** Reads a world without taking it. Its owner may write meanwhile. */
    static StoreReading read(PostgresUrl url, String world) throws IOException {
        String name = new StoreAddress.InDatabase(url, world, Optional.empty()).toString();
        return reading(
                url,
                PostgresContents.none(name),
                connection -> PostgresContents.read(connection, name, world));
    }

    /**
     * Returns the worlds of a database, by name.
     *
     * @throws IOException if the database is away
     */
    public static List<World> worlds(PostgresUrl url) throws IOException {
        return reading(url, List.of(), PostgresStore::worlds);
    }

    /** Returns the worlds of a database that has the tables, by name. */
    static List<World> worlds(Connection connection) throws SQLException {
        return PostgresSession.query(
                connection,
                WORLDS + " ORDER BY name COLLATE \"C\"",
                rows -> {
                    List<World> found = new ArrayList<>();
                    while (rows.next()) {
                        found.add(World.read(rows));
                    }
                    return List.copyOf(found);
                });
    }

    /**
     * Waits until no server has a world: until the lease of its owner has ended, or the owner has
     * given the world back. Also waits while the database cannot be reached, and while a world is
     * missing that must be there.
     *
     * @param mustExist whether only the database has the world; a world that this method has seen
     *     must also be there
     * @param owners receives the present owner when the wait begins, and each later owner
     * @param problems receives a message when the database cannot be reached any more, or lacks the
     *     world
     * @throws IOException if the thread is interrupted
     */
    public static void awaitFree(
            PostgresUrl url,
            String world,
            boolean mustExist,
            Consumer<World> owners,
            Consumer<String> problems)
            throws IOException {
        long known = 0;
        boolean isAway = false;
        boolean isMissing = false;
        String lease = "";
        long extendedNanos = System.nanoTime();
        try (PostgresSession session = new PostgresSession(url, FRAME_PATIENCE_SECONDS, true)) {
            while (!Thread.currentThread().isInterrupted()) {
                try {
                    Optional<World> now = session.run("read", used -> find(used, world));
                    isAway = false;
                    if (now.isEmpty() && (mustExist || known > 0)) {
                        if (!isMissing) {
                            problems.accept(
                                    url + " has no world " + world + "; this server waits for it");
                        }
                        isMissing = true;
                    } else if (now.isEmpty() || !now.get().isOwned()) {
                        return;
                    } else if (now.get().lease().equals(lease) && isSilentSince(extendedNanos)) {
                        return;
                    }
                    if (now.isPresent() && !now.get().lease().equals(lease)) {
                        lease = now.get().lease();
                        extendedNanos = System.nanoTime();
                    }
                    if (now.isPresent() && now.get().epoch() != known) {
                        isMissing = false;
                        known = now.get().epoch();
                        owners.accept(now.get());
                    }
                } catch (IOException away) {
                    if (!isAway) {
                        problems.accept(away.getMessage() + "; this server waits for it");
                    }
                    isAway = true;
                }
                LockSupport.parkNanos(ATTEMPT_NANOSECONDS);
            }
        }
        throw new IOException(url + ": the wait for the world " + world + " was interrupted");
    }

    /**
     * Returns whether an owner has not extended its lease for as long as a lease lasts, by the
     * clock of this process. The clock of the database may have been set back.
     */
    private static boolean isSilentSince(long nanos) {
        return System.nanoTime() - nanos > LEASE_NANOSECONDS + ATTEMPT_NANOSECONDS;
    }

    private static Optional<World> find(Connection connection, String world) throws SQLException {
        return requireVersion(connection).isEmpty()
                ? Optional.empty()
                : PostgresSession.query(
                        connection,
                        WORLDS + " WHERE name = ?",
                        rows -> rows.next() ? Optional.of(World.read(rows)) : Optional.empty(),
                        world);
    }

    /**
     * Returns the pack of a world: the world and all files that it needs.
     *
     * @return empty if the database has no such world
     * @throws CorruptException if the pack is damaged
     * @throws IOException if the database is away
     */
    public static Optional<byte[]> pack(PostgresUrl url, String world) throws IOException {
        return reading(
                url,
                Optional.empty(),
                connection ->
                        PostgresSession.query(
                                connection,
                                "SELECT sha256, bytes FROM reve.pack WHERE world = ?",
                                rows -> {
                                    if (!rows.next()) {
                                        return Optional.<byte[]>empty();
                                    }
                                    byte[] bytes = rows.getBytes(2);
                                    if (!StoreDatabase.sha256(bytes).equals(rows.getString(1))) {
                                        throw new CorruptException(
                                                url
                                                        + ": the pack of the world "
                                                        + world
                                                        + " is damaged; start the server once with"
                                                        + " the world file, which replaces it");
                                    }
                                    return Optional.of(bytes);
                                },
                                world));
    }

    private static <T> T reading(PostgresUrl url, T none, PostgresSession.Work<T> work)
            throws IOException {
        try (PostgresSession session = new PostgresSession(url, IMAGE_PATIENCE_SECONDS, true)) {
            boolean hasTables =
                    session.run("read", connection -> requireVersion(connection).isPresent());
            return hasTables ? session.transaction("read", work) : none;
        }
    }

    /** Returns the version of the tables; empty if there are none. */
    private static Optional<Integer> requireVersion(Connection connection) throws SQLException {
        boolean exists =
                PostgresSession.query(
                        connection,
                        "SELECT to_regclass('reve.version') IS NOT NULL",
                        rows -> rows.next() && rows.getBoolean(1));
        if (!exists) {
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
                            + "; use the program with which they were written, or another"
                            + " database");
        }
        return Optional.of(version);
    }

    /** Creates the tables in a database that has none; returns whether it did. */
    static boolean createTables(Connection connection) throws SQLException {
        if (requireVersion(connection).isPresent()) {
            return false;
        }
        PostgresSession.query(
                connection, "SELECT pg_advisory_xact_lock(?)", rows -> rows.next(), CREATION_LOCK);
        if (requireVersion(connection).isPresent()) {
            return false;
        }
        try (Statement statement = connection.createStatement()) {
            for (String table : TABLES) {
                statement.execute(table);
            }
        }
        return true;
    }

    private long grant(Consumer<String> problems) throws IOException {
        long start = System.nanoTime();
        boolean told = false;
        Owner seen = null;
        while (true) {
            requireRow();
            String silent = seen != null && isSilentSince(start) ? seen.until() : "";
            OptionalLong granted =
                    images.run(
                            "written",
                            connection ->
                                    PostgresSession.query(
                                            connection,
                                            GRANT,
                                            rows ->
                                                    rows.next()
                                                            ? OptionalLong.of(rows.getLong(1))
                                                            : OptionalLong.empty(),
                                            world,
                                            self,
                                            silent));
            if (granted.isPresent()) {
                return granted.getAsLong();
            }
            Optional<Owner> now = owner();
            if (now.isEmpty()) {
                continue; // the world was removed meanwhile
            }
            if (seen != null && !now.get().isStill(seen)) {
                throw new InUseException(
                        address
                                + " is in use by "
                                + now.get().name()
                                + " (epoch "
                                + now.get().epoch()
                                + "); end that server first, or name another database");
            }
            seen = now.get();
            if (!told && System.nanoTime() - start > RENEWAL_NANOSECONDS + ATTEMPT_NANOSECONDS) {
                told = true;
                problems.accept(
                        address
                                + " was taken by "
                                + seen.name()
                                + ", which does not answer; this server takes the world in "
                                + Math.round(Math.clamp(seen.seconds(), 0, LEASE_SECONDS))
                                + " s, when the lease ends");
            }
            LockSupport.parkNanos(ATTEMPT_NANOSECONDS);
            if (Thread.currentThread().isInterrupted()) {
                throw new IOException(address + " was not taken: interrupted");
            }
        }
    }

    /**
     * Refuses a world whose row is missing although there are images of it, because the row says
     * which frames there must be.
     */
    private void requireRow() throws IOException {
        boolean isMissing =
                images.run(
                        "read",
                        connection ->
                                PostgresSession.query(
                                        connection,
                                        "SELECT 1 FROM reve.image WHERE world = ? AND NOT EXISTS"
                                                + " (SELECT 1 FROM reve.world WHERE name = ?) LIMIT 1",
                                        ResultSet::next,
                                        world,
                                        world));
        if (isMissing) {
            try (PostgresSession session =
                    new PostgresSession(address.url(), IMAGE_PATIENCE_SECONDS, true)) {
                session.transaction(
                                "read",
                                connection ->
                                        PostgresContents.read(
                                                connection, address.toString(), world))
                        .requireWhole();
            }
        }
    }

    private Optional<Owner> owner() throws IOException {
        return images.run(
                "read",
                connection ->
                        PostgresSession.query(
                                connection,
                                "SELECT epoch, owner, lease_until::text, extract(epoch FROM"
                                        + " lease_until - clock_timestamp())::float8 FROM reve.world"
                                        + " WHERE name = ?",
                                rows ->
                                        rows.next()
                                                ? Optional.of(
                                                        new Owner(
                                                                rows.getLong(1),
                                                                rows.getString(2),
                                                                rows.getString(3),
                                                                rows.getDouble(4)))
                                                : Optional.<Owner>empty(),
                                world));
    }

    private static String thisServer() {
        String host;
        try {
            host = Files.readString(Path.of("/proc/sys/kernel/hostname")).strip();
        } catch (IOException unknown) {
            host = "an unknown machine";
        }
        return "%s, use %016x, process %d"
                .formatted(host, RANDOM.nextLong(), ProcessHandle.current().pid());
    }

    private void storePack() throws IOException {
        if (address.pack().isEmpty()) {
            return;
        }
        byte[] bytes = Files.readAllBytes(address.pack().get());
        writeOwned(
                connection -> {
                    PostgresSession.update(
                            connection,
                            "INSERT INTO reve.pack VALUES (?, ?, ?, ?) ON CONFLICT (world) DO"
                                    + " UPDATE SET epoch = excluded.epoch, sha256 = excluded.sha256,"
                                    + " bytes = excluded.bytes",
                            world,
                            epoch,
                            StoreDatabase.sha256(bytes),
                            bytes);
                    return -1L;
                });
    }

    @Override
    public void announce(String agents) throws IOException {
        requireNotLost();
        int rows =
                frames.run(
                        "written",
                        connection ->
                                PostgresSession.update(
                                        connection,
                                        "UPDATE reve.world SET agents = ? WHERE name = ? AND epoch ="
                                                + " ? AND owner = ?",
                                        agents,
                                        world,
                                        epoch,
                                        self));
        if (rows == 0) {
            throw lose();
        }
    }

    @Override
    public void whenLost(Consumer<String> listener) {
        synchronized (loss) {
            lostListener = listener;
            LostException already = lost;
            if (already != null) {
                listener.accept(already.getMessage());
            }
        }
    }

    @Override
    public void write(JournalRecord record) throws IOException {
        requireNotLost();
        long before = System.nanoTime();
        int rows =
                switch (record) {
                    case JournalRecord.Frame frame ->
                            frames.run(
                                    "written",
                                    connection ->
                                            PostgresSession.update(
                                                    connection,
                                                    ADD_FRAME,
                                                    frame.frame(),
                                                    world,
                                                    epoch,
                                                    self,
                                                    reached.get(),
                                                    image,
                                                    frame.frame(),
                                                    frame.json(),
                                                    StoreDatabase.checksum(
                                                            frame.json(), image, frame.frame())));
                    case JournalRecord.Library library ->
                            frames.run(
                                    "written",
                                    connection ->
                                            PostgresSession.update(
                                                    connection,
                                                    ADD_LIBRARY,
                                                    -1L,
                                                    world,
                                                    epoch,
                                                    self,
                                                    library.sha256(),
                                                    library.bytes()));
                    case JournalRecord.Image _ ->
                            throw new IllegalStateException("an image needs a place");
                };
        if (rows == 0 && !isDone(record, end())) {
            throw new GapException(
                    address
                            + " does not end with frame "
                            + reached
                            + ", which was acknowledged; the database has lost its last data, for"
                            + " example by a crash");
        }
        confirm(before);
        if (record instanceof JournalRecord.Frame frame) {
            reached.set(frame.frame());
        }
    }

    /** Returns whether the write of a frame was done by a connection that was lost afterwards. */
    private static boolean isDone(JournalRecord record, long end) {
        return record instanceof JournalRecord.Frame frame && frame.frame() == end;
    }

    /**
     * Returns the frame with which the world ends in the database.
     *
     * @throws LostException if another server has the world
     */
    private long end() throws IOException {
        OptionalLong end =
                frames.run(
                        "read",
                        connection ->
                                PostgresSession.query(
                                        connection,
                                        "SELECT frame FROM reve.world WHERE name = ? AND epoch = ?"
                                                + " AND owner = ?",
                                        rows ->
                                                rows.next()
                                                        ? OptionalLong.of(rows.getLong(1))
                                                        : OptionalLong.empty(),
                                        world,
                                        epoch,
                                        self));
        if (end.isEmpty()) {
            throw lose();
        }
        return end.getAsLong();
    }

    @Override
    public Place place() throws IOException {
        requireNotLost();
        long number = image + 1;
        image = number;
        return (libraries, state) -> write(number, libraries, state);
    }

    private void write(
            long number, List<JournalRecord.Library> libraries, JournalRecord.Image state)
            throws IOException {
        requireNotLost();
        writeOwned(
                connection -> {
                    for (JournalRecord.Library library : libraries) {
                        add(connection, library);
                    }
                    PostgresSession.update(
                            connection,
                            "INSERT INTO reve.image VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT"
                                    + " (world, epoch, number) DO UPDATE SET frame = excluded.frame,"
                                    + " bytes = excluded.bytes, crc32c = excluded.crc32c",
                            world,
                            epoch,
                            number,
                            state.frame(),
                            state.bytes(),
                            StoreDatabase.checksum(state.bytes(), number, state.frame()));
                    dropOld(connection);
                    return state.frame();
                });
        reached.accumulateAndGet(state.frame(), Math::max);
    }

    /** Adds a library unless the database has the same bytes, because libraries are large. */
    private void add(Connection connection, JournalRecord.Library library) throws SQLException {
        boolean isThere =
                PostgresSession.query(
                        connection,
                        "SELECT encode(sha256(bytes), 'hex') = sha256 FROM reve.library"
                                + " WHERE world = ? AND sha256 = ?",
                        rows -> rows.next() && rows.getBoolean(1),
                        world,
                        library.sha256());
        if (!isThere) {
            PostgresSession.update(
                    connection,
                    "INSERT INTO reve.library VALUES (?, ?, ?, ?) ON CONFLICT (world, sha256)"
                            + " DO UPDATE SET bytes = excluded.bytes, epoch = excluded.epoch",
                    world,
                    library.sha256(),
                    epoch,
                    library.bytes());
        }
    }

    /** Removes all images but the last three, and the frames before the oldest image. */
    private void dropOld(Connection connection) throws SQLException {
        PostgresSession.update(
                connection,
                "DELETE FROM reve.image WHERE world = ? AND number NOT IN (SELECT number FROM"
                        + " reve.image WHERE world = ? ORDER BY number DESC LIMIT "
                        + GENERATIONS
                        + ")",
                world,
                world);
        PostgresSession.update(
                connection,
                "DELETE FROM reve.frame WHERE world = ? AND image < (SELECT min(number) FROM"
                        + " reve.image WHERE world = ?)",
                world,
                world);
    }

    /**
     * Writes in one transaction, and compares the epoch at its end. The row of the world is the
     * last row that the transaction locks.
     *
     * @param work returns the newest frame that it stores; -1 for none
     * @throws LostException after the changes were undone, if another server has the world
     */
    private void writeOwned(PostgresSession.Work<Long> work) throws IOException {
        long before = System.nanoTime();
        try {
            images.transaction(
                    "written",
                    connection -> {
                        long frame = work.run(connection);
                        if (PostgresSession.update(connection, OWNED, frame, world, epoch, self)
                                == 0) {
                            throw new StrangerException();
                        }
                        return true;
                    });
        } catch (StrangerException undone) {
            throw lose();
        }
        confirm(before);
    }

    /**
     * Reports that the epoch of this server has ended. The exception rolls back the transaction.
     */
    private static final class StrangerException extends IOException {
        private static final long serialVersionUID = 1L;
    }

    private void requireNotLost() throws LostException {
        LostException before = lost;
        if (before != null) {
            throw before;
        }
    }

    private void confirm(long nanos) {
        confirmedNanos = nanos;
        toldAway = false;
    }

    /** Extends the lease while no frame is written, for example because the world is paused. */
    private void extendLease() {
        while (!closed && lost == null) {
            LockSupport.parkNanos(RENEWAL_NANOSECONDS / 4);
            long now = System.nanoTime();
            if (closed || now - confirmedNanos < RENEWAL_NANOSECONDS) {
                continue;
            }
            try {
                int rows =
                        frames.run(
                                "written",
                                connection ->
                                        PostgresSession.update(
                                                connection, OWNED, -1L, world, epoch, self));
                if (rows == 0) {
                    lose();
                } else {
                    confirm(now);
                }
            } catch (IOException away) {
                LockSupport.parkNanos(RENEWAL_NANOSECONDS);
            }
        }
    }

    /**
     * Records that another server has the world. Notifies the listener once, before any thread
     * receives the exception.
     */
    private LostException lose() {
        synchronized (loss) {
            LostException before = lost;
            if (before != null) {
                return before;
            }
            LostException now = new LostException(lossMessage());
            lostListener.accept(now.getMessage());
            lost = now;
            return now;
        }
    }

    private String lossMessage() {
        String other;
        try (PostgresSession session =
                new PostgresSession(address.url(), FRAME_PATIENCE_SECONDS, false)) {
            other =
                    session.run(
                            "read",
                            connection ->
                                    PostgresSession.query(
                                            connection,
                                            "SELECT owner, epoch FROM reve.world WHERE name = ?",
                                            rows ->
                                                    rows.next()
                                                            ? "was taken by "
                                                                    + rows.getString(1)
                                                                    + " (epoch "
                                                                    + rows.getLong(2)
                                                                    + ")"
                                                            : "was removed from the database",
                                            world));
        } catch (IOException unknown) {
            other = "was taken by another server";
        }
        return address
                + " "
                + other
                + ". This server wrote in epoch "
                + epoch
                + " and can store nothing after frame "
                + reached
                + "; it stops the world";
    }

    @Override
    public List<String> troubles() {
        boolean isAway = System.nanoTime() - confirmedNanos > LEASE_NANOSECONDS;
        if (!isAway || toldAway || lost != null) {
            return List.of();
        }
        toldAway = true;
        return List.of(
                address
                        + " was not written for "
                        + LEASE_NANOSECONDS / 1_000_000_000L
                        + " s, so the lease has ended: another server may take the world. This one"
                        + " continues until it learns that; see that the database runs and can be"
                        + " reached");
    }

    @Override
    public void sync() {
        // This method does nothing, because each commit of the database flushes the data that must
        // survive a power failure.
    }

    @Override
    public void hurry(Duration limit) {
        frames.endWithin(limit);
        images.endWithin(limit);
    }

    /** Ends the lease, so that the next server need not wait, and disconnects. Idempotent. */
    @Override
    public synchronized void close() throws IOException {
        if (closed) {
            return;
        }
        closed = true;
        try (images;
                frames) {
            if (epoch > 0 && lost == null) {
                images.run(
                        "written",
                        connection ->
                                PostgresSession.update(connection, RELEASE, world, epoch, self));
            }
        }
    }
}
