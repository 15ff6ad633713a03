// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.SessionNote;
import reve.core.image.CorruptException;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.security.SecureRandom;
import java.sql.Connection;
import java.sql.ResultSet;
import java.sql.SQLException;
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
 * granted an epoch, a number that grows with each grant. The row of the world contains the epoch
 * and the owner, a text that is different for each server. The epoch alone is not sufficient,
 * because it is granted again after the database was restored from a backup. Each write of the
 * server compares its epoch and its own text with the row, in the same transaction. Each write
 * therefore fails with a {@link JournalSink.LostException} after another server has taken the
 * world. For the threads of a journal.
 */
public final class PostgresStore implements JournalSink {
    private static final int GENERATIONS = 3;

    /**
     * Duration of a lease [s]: after a write, no other server can take the world during this time.
     */
    public static final int LEASE_SECONDS = 10;

    private static final String LEASE = "interval '" + LEASE_SECONDS + " s'";
    private static final long LEASE_NANOSECONDS = LEASE_SECONDS * 1_000_000_000L;

    /** Time without a write after which the lease is extended [ns]. */
    private static final long RENEWAL_NANOSECONDS = 2_000_000_000L;

    /** Interval between two attempts to take a world whose lease has not ended [ns]. */
    private static final long ATTEMPT_NANOSECONDS = 250_000_000L;

    private static final int FRAME_PATIENCE_SECONDS = 10;
    private static final int IMAGE_PATIENCE_SECONDS = 60;

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
     * Adds the frame that follows the last one. A single statement does all the work, so that the
     * database keeps no lock while it waits for this process.
     */
    private static final String ADD_FRAME =
            "WITH owned AS ("
                    + OWNED
                    + " AND frame = ? RETURNING name, epoch) INSERT INTO reve.frame"
                    + " SELECT name, ?, ?, epoch, ?, ? FROM owned";

    /** Adds a frame and the notes about sessions that belong to it, either both or none. */
    private static final String ADD_FRAME_AND_NOTES =
            "WITH owned AS ("
                    + OWNED
                    + " AND frame = ? RETURNING name, epoch), added AS (INSERT INTO reve.frame"
                    + " (world, image, frame, epoch, bytes, crc32c, notes)"
                    + " SELECT name, ?, ?, epoch, ?, ?, ? FROM owned) INSERT INTO"
                    + " reve.session_note SELECT name, epoch, ?, false, ? FROM owned";

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

    /**
     * The owner's text in the row of the world. It identifies this server and this use of the
     * world.
     */
    private final String self = thisServer();

    /** Session that writes frames and extends the lease. */
    private final PostgresSession frames;

    /** Session that writes images, so that frames do not wait for them. */
    private final PostgresSession images;

    private final Object loss = new Object();
    private long epoch;
    private volatile @Nullable PostgresContents contents;
    private volatile List<CarriedSession> sessions = List.of();

    /** Whether the database has the table and the columns for notes about sessions. */
    private volatile boolean keepsSessions;

    /** The sessions after the last frame that was written. For the thread that writes frames. */
    private final NotedSessions noted = new NotedSessions();

    /** Notes that are not written yet. For the thread that writes frames. */
    private final List<SessionNote> notes = new ArrayList<>();

    private volatile long image;
    private final AtomicLong reached = new AtomicLong(-1);
    private volatile long confirmedNanos;
    private volatile boolean closed;
    private volatile @Nullable LostException lost;
    private Consumer<String> lostListener = _ -> {};
    private volatile boolean toldAway;

    /**
     * The owner of a world and the end of its lease. The owner has extended the lease if the end
     * has become later.
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
            store.images.transaction("opened", PostgresTables::create);
            store.epoch = store.grant(problems);
            store.confirmedNanos = System.nanoTime();
            // The lease is extended meanwhile, because reading a large world may take longer than
            // the lease.
            Thread.ofVirtual().name("lease of " + store.world).start(store::extendLease);
            PostgresContents read =
                    store.images.transaction(
                            "read",
                            connection ->
                                    PostgresContents.read(
                                            connection, address.toString(), address.world()));
            store.contents = read;
            store.sessions =
                    store.images.transaction(
                            "read",
                            connection ->
                                    store.takeSessions(
                                            connection,
                                            read.frame(),
                                            problem -> problems.accept(address + ": " + problem)));
            store.image = read.lastImage();
            store.reached.set(read.frame());
            store.requireNotLost();
        } catch (IOException | RuntimeException refused) {
            store.closeAfter(refused);
            throw refused;
        }
        return store.taken();
    }

    private List<CarriedSession> takeSessions(
            Connection connection, long frame, Consumer<String> problems) throws SQLException {
        keepsSessions = NotedSessions.areKept(connection);
        return CarriedSessions.takeAll(connection, world, epoch, frame, problems);
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
            public List<CarriedSession> sessions() {
                return sessions;
            }

            @Override
            public JournalSink open() throws IOException {
                storePack();
                opened = true;
                contents = null; // an image may be large, so it is not kept in memory
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

    /**
     * Returns the worlds of a database, by name.
     *
     * @throws IOException if the database cannot be reached
     */
    public static List<World> worlds(PostgresUrl url) throws IOException {
        return PostgresTables.reading(url, List.of(), PostgresStore::worlds);
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
     * @param mustExist true if only the database has the world, so that it must be there. A world
     *     that this method has found once must also be there
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
     * Returns whether an owner has not extended its lease for the duration of a lease. The clock of
     * this process decides, because the clock of the database may have been set back.
     */
    private static boolean isSilentSince(long nanos) {
        return System.nanoTime() - nanos > LEASE_NANOSECONDS + ATTEMPT_NANOSECONDS;
    }

    private static Optional<World> find(Connection connection, String world) throws SQLException {
        return PostgresTables.requireVersion(connection).isEmpty()
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
     * @throws IOException if the database cannot be reached
     */
    public static Optional<byte[]> pack(PostgresUrl url, String world) throws IOException {
        return PostgresTables.reading(
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
     * Refuses a world whose row is missing although there are images of it, because only the row
     * states which frames must exist.
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
    public void handOver(long frame, List<CarriedSession> handedOver) throws IOException {
        requireNotLost();
        writeOwned(
                connection -> {
                    CarriedSessions.write(connection, world, epoch, frame, handedOver);
                    return -1L;
                });
    }

    @Override
    public void sleep() throws IOException {
        requireNotLost();
        writeOwned(
                connection -> {
                    PostgresCatalog.markAsleep(connection, world, epoch);
                    return -1L;
                });
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
                    case JournalRecord.Frame frame -> add(frame);
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
            applyNotes();
        }
    }

    /** Adds a frame with its notes about sessions, and returns the number of added rows. */
    private int add(JournalRecord.Frame frame) throws IOException {
        List<Object> values =
                new ArrayList<>(
                        List.of(
                                frame.frame(),
                                world,
                                epoch,
                                self,
                                reached.get(),
                                image,
                                frame.frame(),
                                frame.json(),
                                StoreDatabase.checksum(frame.json(), image, frame.frame())));
        if (!notes.isEmpty()) {
            String text = NotedSessions.write(notes);
            values.add(NotedSessions.reference(text, epoch, frame.frame(), false));
            values.add(frame.frame());
            values.add(text);
        }
        return frames.run(
                "written",
                connection ->
                        PostgresSession.update(
                                connection,
                                notes.isEmpty() ? ADD_FRAME : ADD_FRAME_AND_NOTES,
                                values.toArray()));
    }

    @Override
    public boolean keepsSessions() {
        return keepsSessions;
    }

    @Override
    public void note(List<SessionNote> added) {
        if (keepsSessions) {
            notes.addAll(added);
        }
    }

    private void applyNotes() {
        noted.apply(notes);
        notes.clear();
    }

    /** Returns whether the write of a frame was done by a connection that was lost afterwards. */
    private static boolean isDone(JournalRecord record, long end) {
        return record instanceof JournalRecord.Frame frame && frame.frame() == end;
    }

    /**
     * Returns the newest frame of the world in the database.
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
        applyNotes();
        String whole = noted.whole();
        return (libraries, state) -> write(number, libraries, state, whole);
    }

    /**
     * @param whole the sessions after the frame of the image
     */
    private void write(
            long number,
            List<JournalRecord.Library> libraries,
            JournalRecord.Image state,
            String whole)
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
                    if (keepsSessions) {
                        NotedSessions.replace(
                                connection, world, epoch, number, state.frame(), whole);
                    }
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
     * Writes in one transaction, and compares the epoch at the end of the transaction. The row of
     * the world is the last row that the transaction locks, so that it is locked only briefly.
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
                        + LEASE_SECONDS
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
