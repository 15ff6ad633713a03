// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.image.CorruptException;

import java.io.IOException;
import java.sql.Connection;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Stream;

/**
 * The content of a world's rows in a shared database, and the damage that reading them has found.
 * For one thread.
 */
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

    /** All frames since the oldest image, if they were read. */
    private final List<JournalRecord> history = new ArrayList<>();

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

    /** A frame, and whether its bytes are as they were written. */
    private record FrameRow(long image, JournalRecord.Frame frame, boolean isGood) {}

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
            // A longer limit on idle time is set, because the database counts the time in which
            // this process receives rows as idle.
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

    /**
     * Reads a world without taking it. Its owner may write meanwhile.
     *
     * @param isHistory whether the records contain all frames since the oldest image
     */
    static PostgresContents of(StoreAddress.InDatabase address, boolean isHistory)
            throws IOException {
        return PostgresTables.reading(
                address.url(),
                new PostgresContents(address.toString()),
                connection -> {
                    PostgresContents contents =
                            read(connection, address.toString(), address.world());
                    if (isHistory) {
                        contents.readHistory(connection, address.world());
                    }
                    return contents;
                });
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
        List<ImageRow> images = images(connection, world);
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

    /** Returns the images of a world, the newest one first. */
    private static List<ImageRow> images(Connection connection, String world) throws SQLException {
        return PostgresSession.query(
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

    /** Returns the frames since an image, in order. */
    private static List<FrameRow> frames(Connection connection, String world, long image)
            throws SQLException {
        return PostgresSession.query(
                connection,
                "SELECT image, frame, bytes, crc32c FROM reve.frame WHERE world = ? AND image >= ?"
                        + " ORDER BY image, frame, epoch",
                rows -> {
                    List<FrameRow> found = new ArrayList<>();
                    while (rows.next()) {
                        long number = rows.getLong(2);
                        byte[] json = rows.getBytes(3);
                        found.add(
                                new FrameRow(
                                        rows.getLong(1),
                                        new JournalRecord.Frame(number, json),
                                        StoreDatabase.checksum(json, rows.getLong(1), number)
                                                == rows.getLong(4)));
                    }
                    return found;
                },
                world,
                image);
    }

    private Start follow(Connection connection, String world, ImageRow row, byte[] bytes)
            throws SQLException {
        List<JournalRecord> after = new ArrayList<>();
        List<String> why = new ArrayList<>();
        long reached = row.frame();
        for (FrameRow each : frames(connection, world, row.number())) {
            long number = each.frame().frame();
            known = Math.max(known, number);
            if (!why.isEmpty()) {
                continue;
            }
            if (number != reached + 1 || !each.isGood()) {
                why.add(
                        name
                                + ": frame "
                                + (reached + 1)
                                + (number == reached + 1 ? " is damaged" : " is missing"));
                continue;
            }
            after.add(each.frame());
            reached = number;
        }
        return new Start(new JournalRecord.Image(row.frame(), bytes), after, reached, why);
    }

    /**
     * Reads all frames since the oldest image. An image that follows its frame adds nothing. Where
     * frames are missing, the records continue with the next image.
     */
    private void readHistory(Connection connection, String world) throws SQLException {
        List<ImageRow> images = images(connection, world).reversed();
        List<FrameRow> frames =
                images.isEmpty()
                        ? List.of()
                        : frames(connection, world, images.getFirst().number());
        long reached = -1;
        for (int i = 0; i < images.size(); i++) {
            ImageRow row = images.get(i);
            if (history.isEmpty() || row.frame() != reached) {
                Optional<byte[]> bytes = bytes(connection, world, row);
                if (bytes.isPresent()) {
                    history.add(new JournalRecord.Image(row.frame(), bytes.get()));
                    reached = row.frame();
                }
            }
            long next = i + 1 < images.size() ? images.get(i + 1).number() : Long.MAX_VALUE;
            for (FrameRow each : frames) {
                boolean isNext =
                        !history.isEmpty()
                                && each.image() >= row.number()
                                && each.image() < next
                                && each.frame().frame() == reached + 1
                                && each.isGood();
                if (isNext) {
                    history.add(each.frame());
                    reached++;
                }
            }
        }
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
        if (!history.isEmpty()) {
            records.addAll(history);
        } else if (start != null) {
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
