// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.image.CorruptException;

import java.sql.Connection;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Stream;

/** The content of a world's rows in a shared database, and what is missing. For one thread. */
final class PostgresContents implements StoreReading {
    private static final String BACKUP =
            "restore the database from a backup, or store the world under another name";

    private final String name;
    private boolean hasRow;
    private final Map<String, byte[]> libraries = new LinkedHashMap<>();
    private final List<String> damagedLibraries = new ArrayList<>();

    /** Messages about damage that loses no data. */
    private final List<String> harmless = new ArrayList<>();

    /** Messages about damage that loses data. */
    private final List<String> damage = new ArrayList<>();

    private @Nullable Start start;
    private long known = -1;
    private long lastImage;

    /** An image and the frames that follow it without a gap. */
    private record Start(
            JournalRecord.Image image, List<JournalRecord> after, long frame, List<String> why) {}

    /** A row of an image, without the bytes of the image. */
    private record ImageRow(long epoch, long number, long frame, long sum) {
        private String text() {
            return "the image of frame " + frame + " (epoch " + epoch + ")";
        }
    }

    private PostgresContents(String name) {
        this.name = name;
    }

    /**
     * Reads the rows of a world in one transaction, which must be the current one.
     *
     * @param name the store, for messages
     */
    static PostgresContents read(Connection connection, String name, String world)
            throws SQLException {
        try (Statement statement = connection.createStatement()) {
            // The database counts the time in which this process receives rows as idle.
            statement.execute(
                    "SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY;"
                            + " SET LOCAL idle_in_transaction_session_timeout = '60s'");
        }
        PostgresContents contents = new PostgresContents(name);
        contents.known =
                PostgresSession.query(
                        connection,
                        "SELECT frame FROM reve.world WHERE name = ?",
                        rows -> {
                            contents.hasRow = rows.next();
                            return contents.hasRow ? rows.getLong(1) : -1L;
                        },
                        world);
        contents.readLibraries(connection, world);
        contents.readJournal(connection, world);
        return contents;
    }

    /** Returns the content of a database that has no table of stores. */
    static PostgresContents none(String name) {
        return new PostgresContents(name);
    }

    private void readLibraries(Connection connection, String world) throws SQLException {
        PostgresSession.query(
                connection,
                "SELECT sha256, bytes FROM reve.library WHERE world = ? ORDER BY sha256",
                rows -> {
                    while (rows.next()) {
                        byte[] bytes = rows.getBytes(2);
                        String found = StoreDatabase.sha256(bytes);
                        if (!found.equals(rows.getString(1))) {
                            damagedLibraries.add(rows.getString(1));
                        }
                        libraries.put(found, bytes);
                    }
                    return null;
                },
                world);
    }

    private void readJournal(Connection connection, String world) throws SQLException {
        List<ImageRow> images =
                PostgresSession.query(
                        connection,
                        "SELECT epoch, number, frame, crc32c FROM reve.image WHERE world = ?"
                                + " ORDER BY number DESC, epoch DESC",
                        rows -> {
                            List<ImageRow> found = new ArrayList<>();
                            while (rows.next()) {
                                found.add(
                                        new ImageRow(
                                                rows.getLong(1),
                                                rows.getLong(2),
                                                rows.getLong(3),
                                                rows.getLong(4)));
                            }
                            return found;
                        },
                        world);
        lastImage =
                PostgresSession.query(
                        connection,
                        "SELECT coalesce(max(image), 0) FROM reve.frame WHERE world = ?",
                        rows -> rows.next() ? rows.getLong(1) : 0L,
                        world);
        for (ImageRow row : images) {
            lastImage = Math.max(lastImage, row.number());
            known = Math.max(known, row.frame());
        }
        for (ImageRow row : images) {
            if (start != null && start.frame() >= known) {
                break;
            }
            Optional<byte[]> bytes = bytes(connection, world, row);
            if (bytes.isEmpty()) {
                harmless.add(name + ": " + row.text() + " is damaged");
                continue;
            }
            Start found = follow(connection, world, row, bytes.get());
            if (start == null || found.frame() > start.frame()) {
                start = found;
            }
        }
        judge(images.isEmpty());
    }

    private static Optional<byte[]> bytes(Connection connection, String world, ImageRow row)
            throws SQLException {
        return PostgresSession.query(
                        connection,
                        "SELECT bytes FROM reve.image WHERE world = ? AND epoch = ? AND number = ?",
                        rows ->
                                rows.next()
                                        ? Optional.of(rows.getBytes(1))
                                        : Optional.<byte[]>empty(),
                        world,
                        row.epoch(),
                        row.number())
                .filter(
                        bytes ->
                                StoreDatabase.checksum(bytes, row.number(), row.frame())
                                        == row.sum());
    }

    private Start follow(Connection connection, String world, ImageRow row, byte[] bytes)
            throws SQLException {
        List<JournalRecord> after = new ArrayList<>();
        List<String> why = new ArrayList<>();
        long frame =
                PostgresSession.query(
                        connection,
                        "SELECT epoch, image, frame, bytes, crc32c FROM reve.frame WHERE world = ?"
                                + " AND image >= ? ORDER BY image, frame, epoch",
                        rows -> {
                            long reached = row.frame();
                            while (rows.next()) {
                                long number = rows.getLong(3);
                                known = Math.max(known, number);
                                byte[] json = rows.getBytes(4);
                                boolean isGood =
                                        StoreDatabase.checksum(json, rows.getLong(2), number)
                                                == rows.getLong(5);
                                if (!why.isEmpty()) {
                                    continue;
                                }
                                if (number != reached + 1 || !isGood) {
                                    why.add(
                                            name
                                                    + ": frame "
                                                    + (reached + 1)
                                                    + (isGood || number != reached + 1
                                                            ? " is missing"
                                                            : " is damaged"));
                                    continue;
                                }
                                after.add(new JournalRecord.Frame(number, json));
                                reached = number;
                            }
                            return reached;
                        },
                        world,
                        row.number());
        return new Start(new JournalRecord.Image(row.frame(), bytes), after, frame, why);
    }

    private void judge(boolean hasNoImage) {
        Start from = start;
        if (!hasRow && !hasNoImage) {
            damage.add(
                    name
                            + " has images, but no row in reve.world, so its last frames may be"
                            + " missing");
        }
        if (from != null && from.frame() >= known) {
            return;
        }
        if (from != null) {
            damage.addAll(
                    from.why().isEmpty()
                            ? List.of(
                                    name
                                            + " ends at frame "
                                            + from.frame()
                                            + ", but went on to frame "
                                            + known)
                            : from.why());
        } else if (!hasNoImage || known >= 0) {
            damage.add(name + " holds no image that can be read");
        }
    }

    /** Returns the largest number of an image that exists or for which there are frames. */
    long lastImage() {
        return lastImage;
    }

    @Override
    public String name() {
        return name;
    }

    @Override
    public boolean isEmpty() {
        return start == null && damage.isEmpty();
    }

    @Override
    public boolean isWhole() {
        return damage.isEmpty();
    }

    @Override
    public List<String> problems() {
        return Stream.concat(damage.stream(), harmless.stream()).distinct().toList();
    }

    @Override
    public long frame() {
        return start == null ? -1 : start.frame();
    }

    @Override
    public long knownFrame() {
        return known;
    }

    @Override
    public List<JournalRecord> records() {
        List<JournalRecord> records = new ArrayList<>();
        libraries.forEach((sha256, bytes) -> records.add(new JournalRecord.Library(sha256, bytes)));
        if (start != null) {
            records.add(start.image());
            records.addAll(start.after());
        }
        return records;
    }

    @Override
    public List<String> damagedLibraries() {
        return List.copyOf(damagedLibraries);
    }

    @Override
    public void requireWhole() {
        if (!isWhole()) {
            throw refusal(String.join("; ", problems()), frame());
        }
    }

    @Override
    public CorruptException refusal(String reason, long frame) {
        return new CorruptException(
                name
                        + " is not whole: "
                        + reason
                        + ". "
                        + (frame < 0
                                ? "Nothing can be recovered from these rows"
                                : "It can continue from frame "
                                        + frame
                                        + (known > frame
                                                ? "; frames "
                                                        + (frame + 1)
                                                        + " to "
                                                        + known
                                                        + " would be lost"
                                                : ""))
                        + "; "
                        + BACKUP
                        + " (nothing was changed)");
    }
}
