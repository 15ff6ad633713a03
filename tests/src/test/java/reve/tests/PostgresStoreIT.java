// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIOException;

import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;

import reve.core.image.CorruptException;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.SqliteStore.Durability;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.StoreReading;
import reve.worlds.journal.TakenStore;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.security.MessageDigest;
import java.sql.Connection;
import java.sql.SQLException;
import java.sql.Statement;
import java.time.Duration;
import java.util.ArrayList;
import java.util.HexFormat;
import java.util.List;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.atomic.AtomicLong;

/**
 * The store of several servers with a real database. The tests check epochs, takeovers and damage.
 */
@Tag("slow")
class PostgresStoreIT {
    private static final long SEED = Long.getLong("reve.test.seed", 20261128);

    /** Number of takeovers. A long run uses 200. */
    private static final int TAKEOVERS = Integer.getInteger("reve.test.takeovers", 25);

    private static Postgres postgres;
    private static int databases;

    private final List<String> problems = new ArrayList<>();

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    private static String database() throws SQLException {
        String name = "store" + ++databases;
        postgres.create(name);
        return name;
    }

    private static StoreAddress address(String database) {
        return new StoreAddress.InDatabase(
                PostgresUrl.find(postgres.url(database)).orElseThrow(), "w", Optional.empty());
    }

    private TakenStore take(String database) throws IOException {
        return address(database).take(Durability.NORMAL, problems::add);
    }

    /** Ends the lease of the owner, as if its time were over. */
    private static void endLease(String database) throws SQLException {
        postgres.execute(database, "UPDATE reve.world SET lease_until = clock_timestamp()");
    }

    private static JournalRecord.Frame frame(long number) {
        return new JournalRecord.Frame(
                number, ("{\"frame\": " + number + "}").getBytes(StandardCharsets.UTF_8));
    }

    private static JournalRecord.Image image(long number) {
        return new JournalRecord.Image(
                number, ("image " + number).getBytes(StandardCharsets.UTF_8));
    }

    private static JournalRecord.Library library(String content) throws Exception {
        byte[] bytes = content.getBytes(StandardCharsets.UTF_8);
        return new JournalRecord.Library(
                HexFormat.of().formatHex(MessageDigest.getInstance("SHA-256").digest(bytes)),
                bytes);
    }

    private static List<String> texts(StoreReading contents) {
        return contents.records().stream()
                .map(
                        record ->
                                switch (record) {
                                    case JournalRecord.Library library ->
                                            "library "
                                                    + new String(
                                                            library.bytes(),
                                                            StandardCharsets.UTF_8);
                                    case JournalRecord.Image image ->
                                            new String(image.bytes(), StandardCharsets.UTF_8);
                                    case JournalRecord.Frame frame -> "frame " + frame.frame();
                                })
                .toList();
    }

    @Test
    void theSuccessorReadsWhatWasAcknowledgedInOrder() throws Exception {
        String database = database();
        try (TakenStore taken = take(database)) {
            assertThat(taken.epoch()).hasValue(1);
            assertThat(taken.contents().isEmpty()).isTrue();
            try (JournalSink sink = taken.open()) {
                sink.place().write(List.of(library("one")), image(5));
                sink.write(frame(6));
                sink.write(library("two"));
                sink.write(frame(7));
                JournalSink.Place late = sink.place();
                sink.write(frame(8)); // written before its image, which another thread writes
                late.write(List.of(library("one"), library("two")), image(7));
                sink.write(frame(9));
            }
        }
        try (TakenStore next = take(database)) { // the end of the sink has ended the lease
            assertThat(next.epoch()).hasValue(2);
            assertThat(next.contents().problems()).isEmpty();
            assertThat(next.contents().frame()).isEqualTo(9);
            assertThat(texts(next.contents()))
                    .containsExactlyInAnyOrder(
                            "library one", "library two", "image 7", "frame 8", "frame 9")
                    .endsWith("image 7", "frame 8", "frame 9");
        }
        assertThat(problems).isEmpty();
    }

    @Test
    void aServerThatLostItsWorldWritesNothing() throws Exception {
        String database = database();
        List<String> losses = new ArrayList<>();
        try (TakenStore old = take(database);
                JournalSink paused = old.open()) {
            paused.whenLost(losses::add);
            paused.place().write(List.of(), image(0));
            paused.write(frame(1));
            JournalSink.Place reserved = paused.place();
            endLease(database);
            try (TakenStore taken = take(database);
                    JournalSink owner = taken.open()) {
                assertThat(taken.epoch()).hasValue(2);
                assertThat(owner).isNotNull();
                String all =
                        "SELECT 'f', epoch, frame FROM reve.frame UNION SELECT 'i', epoch, number"
                                + " FROM reve.image UNION SELECT 'l', epoch, 0 FROM reve.library"
                                + " UNION SELECT 'w', epoch, frame FROM reve.world ORDER BY 1, 2, 3";
                List<String> before = postgres.query(database, all);
                assertThat(before).containsExactly("f,1,1", "i,1,1", "w,2,1");
                // an image first, because the sink tries nothing after it has learned of the loss
                assertThatExceptionOfType(JournalSink.LostException.class)
                        .isThrownBy(() -> reserved.write(List.of(library("late")), image(1)))
                        .withMessageContainingAll(
                                postgres.url(database) + " (w) was taken by ",
                                ", process " + ProcessHandle.current().pid() + " (epoch 2)",
                                "wrote in epoch 1 and can store nothing after frame 1",
                                "it stops the world");
                assertThatExceptionOfType(JournalSink.LostException.class)
                        .isThrownBy(() -> paused.write(frame(2)));
                assertThat(postgres.query(database, all)).isEqualTo(before);
                owner.place().write(List.of(), image(1));
                owner.write(frame(2));
            }
        }
        assertThat(losses).hasSize(1);
        assertThat(address(database).read().frame()).isEqualTo(2);
    }

    @Test
    void aLateFrameAndALateLibraryAreRefusedByThemselves() throws Exception {
        for (JournalRecord late : List.of(frame(2), library("late"))) {
            String database = database();
            try (TakenStore old = take(database);
                    JournalSink paused = old.open()) {
                paused.place().write(List.of(), image(0));
                paused.write(frame(1));
                endLease(database);
                try (TakenStore taken = take(database)) {
                    assertThat(taken.contents().frame()).isEqualTo(1);
                    assertThatExceptionOfType(JournalSink.LostException.class)
                            .isThrownBy(() -> paused.write(late));
                }
            }
            assertThat(
                            postgres.query(
                                    database,
                                    "SELECT (SELECT max(frame) FROM reve.frame), (SELECT count(*)"
                                            + " FROM reve.library)"))
                    .containsExactly("1,0");
        }
    }

    /** Even without a write, the owner learns of the loss, by the timer that extends its lease. */
    @Test
    void aServerThatWritesNothingLearnsThatItLostItsWorld() throws Exception {
        String database = database();
        CompletableFuture<String> loss = new CompletableFuture<>();
        try (TakenStore old = take(database);
                JournalSink idle = old.open()) {
            idle.whenLost(loss::complete);
            idle.place().write(List.of(), image(0));
            endLease(database);
            try (TakenStore taken = take(database)) {
                assertThat(taken.epoch()).hasValue(2);
                assertThat(loss.join()).contains("(epoch 2)", "nothing after frame 0");
            }
        }
    }

    /**
     * Owners write frames and images as fast as they can, and each is replaced at a random moment.
     * The successor resumes from exactly the last frame of which the write returned.
     */
    @Test
    void noAcknowledgedFrameIsLostAndNoLaterOneIsThere() throws Exception {
        String database = database();
        Random random = new Random(SEED);
        TakenStore taken = take(database);
        // Each lease ends at once, as if the owner did not extend it in time.
        postgres.execute(
                database,
                "CREATE FUNCTION end_lease() RETURNS trigger LANGUAGE plpgsql AS 'BEGIN"
                        + " NEW.lease_until := clock_timestamp(); RETURN NEW; END';"
                        + " CREATE TRIGGER end_lease BEFORE UPDATE ON reve.world FOR EACH ROW"
                        + " EXECUTE FUNCTION end_lease()");
        long resumed = 0;
        for (int i = 1; i <= TAKEOVERS; i++) {
            JournalSink owner = taken.open();
            var acknowledged = new AtomicLong(resumed);
            long first = resumed;
            Thread frames = Thread.ofPlatform().start(() -> write(owner, first, acknowledged));
            long pause = System.nanoTime() + random.nextInt(40_000_000);
            while (System.nanoTime() < pause) {
                Thread.onSpinWait();
            }
            TakenStore next = take(database);
            frames.join();
            String which = "takeover " + i + " of seed " + SEED;
            assertThat(next.epoch()).as(which).hasValue(i + 1);
            assertThat(next.contents().problems()).as(which).isEmpty();
            assertThat(Math.max(0, next.contents().frame()))
                    .as(which)
                    .isEqualTo(acknowledged.get());
            owner.close();
            resumed = acknowledged.get();
            taken = next;
        }
        taken.close();
        assertThat(resumed).isPositive();
    }

    private static void write(JournalSink owner, long first, AtomicLong acknowledged) {
        long number = first;
        try {
            owner.place().write(List.of(), image(number));
            while (true) {
                if (number % 20 == 19) {
                    long at = number;
                    JournalSink.Place place = owner.place();
                    CompletableFuture.runAsync(
                            () -> {
                                try {
                                    place.write(List.of(), image(at));
                                } catch (IOException lost) {
                                    // the thread of the frames ends by the same exception
                                }
                            });
                }
                owner.write(frame(number + 1));
                acknowledged.set(++number);
            }
        } catch (JournalSink.LostException lost) {
            // another server has the world
        } catch (IOException e) {
            throw new AssertionError(e);
        }
    }

    /** The row of the world, and with it the epoch, goes back while the owner is paused. */
    @Test
    void anEpochThatIsGrantedTwiceBelongsToOneServer() throws Exception {
        String database = database();
        take(database).close();
        postgres.execute(database, "CREATE TABLE backup AS TABLE reve.world");
        try (TakenStore old = take(database);
                JournalSink paused = old.open()) {
            JournalSink.Place reserved = paused.place();
            postgres.execute(
                    database, "DELETE FROM reve.world; INSERT INTO reve.world TABLE backup");
            try (TakenStore taken = take(database);
                    JournalSink owner = taken.open()) {
                assertThat(taken.epoch()).isEqualTo(old.epoch());
                owner.place().write(List.of(), image(3));
                owner.write(frame(4));
                assertThatExceptionOfType(JournalSink.LostException.class)
                        .isThrownBy(() -> reserved.write(List.of(), image(9)));
                owner.write(frame(5));
            }
        }
        assertThat(texts(address(database).read()))
                .containsExactly("image 3", "frame 4", "frame 5");
    }

    /** A crash of the database may cost the last commits, which do not wait for its disk. */
    @Test
    void aFrameAfterLostOnesIsRefusedUntilAnImageIsStored() throws Exception {
        String database = database();
        try (TakenStore taken = take(database);
                JournalSink sink = taken.open()) {
            sink.place().write(List.of(), image(0));
            for (int i = 1; i <= 3; i++) {
                sink.write(frame(i));
            }
            postgres.execute(
                    database,
                    "DELETE FROM reve.frame WHERE frame = 3; UPDATE reve.world SET frame = 2");
            assertThatExceptionOfType(JournalSink.GapException.class)
                    .isThrownBy(() -> sink.write(frame(4)))
                    .withMessageContainingAll(
                            postgres.url(database) + " (w) does not end with frame 3", "a crash");
            sink.place().write(List.of(), image(5));
            sink.write(frame(6));
        }
        StoreReading found = address(database).read();
        assertThat(found.problems()).isEmpty();
        assertThat(texts(found)).containsExactly("image 5", "frame 6");
    }

    @Test
    void aWorldWithoutItsRowIsRefused() throws Exception {
        String database = database();
        try (TakenStore taken = take(database);
                JournalSink sink = taken.open()) {
            sink.place().write(List.of(), image(0));
        }
        postgres.execute(database, "DELETE FROM reve.world");
        assertThat(address(database).read().isWhole()).isFalse();
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> take(database))
                .withMessageContainingAll(
                        postgres.url(database) + " (w) is not whole: ",
                        "has images, but no row in reve.world",
                        "from a backup");
    }

    /** As after a short restart of the database. */
    @Test
    void writesAreRepeatedOnceOnANewConnection() throws Exception {
        String database = database();
        String cut =
                "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
                        + " WHERE application_name = 'reve'";
        try (TakenStore taken = take(database);
                JournalSink sink = taken.open()) {
            sink.place().write(List.of(), image(0));
            sink.write(frame(1));
            postgres.query(database, cut);
            sink.write(frame(2));
            postgres.query(database, cut);
            sink.place().write(List.of(), image(2));
            sink.write(frame(3));
        }
        assertThat(texts(address(database).read())).containsExactly("image 2", "frame 3");
    }

    /** The clock of the database was set back by an hour. */
    @Test
    void aWorldWhoseOwnerIsSilentIsTakenWhateverTheClockOfTheDatabaseSays() throws Exception {
        String database = database();
        try (TakenStore taken = take(database);
                JournalSink sink = taken.open()) {
            sink.place().write(List.of(), image(0));
        }
        postgres.execute(
                database,
                "UPDATE reve.world SET lease_until = clock_timestamp() + interval '1 hour'");
        try (TakenStore next = take(database)) {
            assertThat(next.epoch()).hasValue(2);
        }
        assertThat(problems).singleElement().asString().contains("takes the world in 10 s");
    }

    /** The process is about to be ended, and the database does not answer. */
    @Test
    void aWriteEndsAtTheLimitOfAServerThatEnds() throws Exception {
        String database = database();
        try (TakenStore taken = take(database);
                JournalSink sink = taken.open()) {
            sink.place().write(List.of(), image(0));
            try (Connection other = postgres.connect(database);
                    Statement statement = other.createStatement()) {
                other.setAutoCommit(false);
                statement.executeUpdate("UPDATE reve.world SET frame = 0");
                sink.hurry(Duration.ofMillis(100));
                assertThatIOException()
                        .isThrownBy(() -> sink.place().write(List.of(), image(1)))
                        .withMessageContaining("could not be written")
                        .withMessageNotContaining("lock timeout");
                assertThatIOException()
                        .isThrownBy(() -> sink.write(frame(1)))
                        .withMessageContaining("this server is ending");
            }
        } catch (IOException unreleased) {
            assertThat(unreleased).hasMessageContaining("this server is ending");
        }
    }

    /** A takeover waits for a write that has compared its epoch and is not yet committed. */
    @Test
    void aTakeoverWaitsForTheCommitOfAWrite() throws Exception {
        String database = database();
        try (TakenStore old = take(database);
                JournalSink owner = old.open()) {
            owner.place().write(List.of(), image(0));
            endLease(database);
            try (Connection write = postgres.connect(database);
                    Statement statement = write.createStatement()) {
                write.setAutoCommit(false);
                assertThat(
                                statement.executeUpdate(
                                        "UPDATE reve.world SET frame = 1 WHERE name = 'w' AND"
                                                + " epoch = 1"))
                        .isEqualTo(1);
                CompletableFuture<TakenStore> taking =
                        CompletableFuture.supplyAsync(
                                () -> {
                                    try {
                                        return take(database);
                                    } catch (IOException e) {
                                        throw new AssertionError(e);
                                    }
                                });
                while (postgres.query(
                                database,
                                "SELECT 1 FROM pg_stat_activity WHERE wait_event_type = 'Lock' AND"
                                        + " query LIKE 'INSERT INTO reve.world%'")
                        .isEmpty()) {
                    Thread.onSpinWait();
                }
                assertThat(taking).isNotDone();
                write.commit();
                try (TakenStore taken = taking.join()) {
                    assertThat(taken.contents().knownFrame()).isEqualTo(1);
                }
            }
        }
    }

    @Test
    void aWorldOfAWorkingServerIsNotTaken() throws Exception {
        String database = database();
        try (TakenStore old = take(database);
                JournalSink owner = old.open()) {
            owner.place().write(List.of(), image(0));
            assertThatIOException()
                    .isThrownBy(() -> take(database))
                    .withMessageContainingAll(
                            postgres.url(database) + " (w) is in use by ",
                            ", process " + ProcessHandle.current().pid() + " (epoch 1)",
                            "end that server first");
            owner.write(frame(1));
        }
        assertThat(PostgresStore.worlds(PostgresUrl.find(postgres.url(database)).orElseThrow()))
                .singleElement()
                .satisfies(
                        world -> {
                            assertThat(world.name()).isEqualTo("w");
                            assertThat(world.epoch()).isEqualTo(1);
                            assertThat(world.frame()).isEqualTo(1);
                            assertThat(world.isOwned()).isFalse();
                        });
    }

    @Test
    void rowsThatWereLostOrChangedAreFound() throws Exception {
        String database = database();
        try (TakenStore taken = take(database);
                JournalSink sink = taken.open()) {
            sink.place().write(List.of(library("one")), image(0));
            sink.write(frame(1));
            sink.place().write(List.of(library("one")), image(1));
            for (int i = 2; i <= 4; i++) {
                sink.write(frame(i));
            }
        }
        String template = "CREATE DATABASE %s TEMPLATE " + database;
        record Damage(String sql, boolean isWhole, long frame, String message) {}
        List<Damage> damages =
                List.of(
                        new Damage(
                                "UPDATE reve.image SET bytes = 'x' WHERE number = 2",
                                true,
                                4,
                                "the image of frame 1 (epoch 1) is damaged"),
                        new Damage("DELETE FROM reve.image WHERE number = 2", true, 4, ""),
                        new Damage(
                                "DELETE FROM reve.frame WHERE frame = 3",
                                false,
                                2,
                                "frame 3 is missing"),
                        new Damage(
                                "DELETE FROM reve.frame WHERE frame = 4",
                                false,
                                3,
                                "ends at frame 3, but went on to frame 4"),
                        new Damage(
                                "UPDATE reve.frame SET bytes = 'x' WHERE frame = 3",
                                false,
                                2,
                                "frame 3 is damaged"),
                        new Damage("DELETE FROM reve.image", false, -1, "holds no image"),
                        new Damage(
                                "UPDATE reve.image SET bytes = 'x'",
                                false,
                                -1,
                                "holds no image that can be read"));
        for (int i = 0; i < damages.size(); i++) {
            Damage damage = damages.get(i);
            String copy = database + "_" + i;
            postgres.execute("postgres", template.formatted(copy));
            postgres.execute(copy, damage.sql());
            StoreReading found = address(copy).read();
            assertThat(found.isWhole()).as(damage.sql()).isEqualTo(damage.isWhole());
            assertThat(found.frame()).as(damage.sql()).isEqualTo(damage.frame());
            if (!damage.message().isEmpty()) {
                assertThat(found.problems())
                        .as(damage.sql())
                        .anyMatch(problem -> problem.contains(damage.message()));
            }
            if (!damage.isWhole()) {
                assertThatExceptionOfType(CorruptException.class)
                        .isThrownBy(found::requireWhole)
                        .withMessageContainingAll(
                                postgres.url(copy) + " (w) is not whole: ", "from a backup");
            }
        }
        String copy = database + "_library";
        postgres.execute("postgres", template.formatted(copy));
        postgres.execute(copy, "UPDATE reve.library SET bytes = 'x'");
        assertThat(address(copy).read().damagedLibraries())
                .containsExactly(library("one").sha256());
    }

    @Test
    void aDatabaseThatCannotBeUsedIsRefusedWithTheReason() throws Exception {
        assertThatIOException()
                .isThrownBy(() -> take("nowhere"))
                .withMessageContainingAll(
                        postgres.url("nowhere") + " could not be opened: ", "createdb nowhere");
        String newer = database();
        take(newer).close();
        postgres.execute(newer, "UPDATE reve.version SET version = 2");
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> take(newer))
                .withMessageContaining("have the version 2, this program reads and writes 1");
        PostgresUrl away = PostgresUrl.find("postgresql://reve@127.0.0.1:1/w").orElseThrow();
        assertThatIOException()
                .isThrownBy(() -> PostgresStore.worlds(away))
                .withMessageContainingAll(
                        "postgresql://reve@127.0.0.1:1/w could not be read: ",
                        "see that the database runs");
        assertThat(PostgresStore.worlds(PostgresUrl.find(postgres.url(database())).orElseThrow()))
                .as("a database without tables")
                .isEmpty();
    }
}
