// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import com.typesafe.config.ConfigFactory;

import org.apache.pekko.coordination.lease.LeaseSettings;
import org.apache.pekko.coordination.lease.javadsl.Lease;
import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Test;

import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.FinishedCommand;
import reve.core.agent.port.SessionNote;
import reve.worlds.cluster.DatabaseLease;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.TakenStore;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.Set;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionException;

/** The lease by which one part of a divided cluster continues, and the list of its worlds. */
class ClusterLeaseIT {
    private static Postgres postgres;
    private static int databases;

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    private static String database() throws Exception {
        String name = "lease" + ++databases;
        postgres.create(name);
        try (PostgresCatalog catalog = catalog(name)) {
            catalog.prepare();
        }
        return name;
    }

    private static PostgresCatalog catalog(String database) {
        return new PostgresCatalog(PostgresUrl.find(postgres.url(database)).orElseThrow());
    }

    /** Returns a lease that lasts longer than a busy machine may pause. */
    private static Lease lease(String database, String owner) {
        return lease(database, owner, "30 s");
    }

    private static Lease lease(String database, String owner, String length) {
        return new DatabaseLease(
                LeaseSettings.apply(
                        ConfigFactory.parseMap(
                                Map.of(
                                        "store",
                                        postgres.url(database),
                                        "heartbeat-interval",
                                        "100 ms",
                                        "heartbeat-timeout",
                                        length,
                                        "lease-operation-timeout",
                                        "300 ms")),
                        "lab-pekko-sbr",
                        owner));
    }

    private static boolean acquires(Lease lease) {
        return lease.acquire().toCompletableFuture().join();
    }

    @Test
    void oneOwnerHasTheLeaseUntilItReleasesIt() throws Exception {
        String database = database();
        Lease first = lease(database, "node 1");
        Lease second = lease(database, "node 2");
        assertThat(first.checkLease()).isFalse();
        assertThat(acquires(first)).isTrue();
        assertThat(first.checkLease()).isTrue();
        assertThat(acquires(second)).isFalse();
        assertThat(second.checkLease()).isFalse();
        assertThat(acquires(first)).as("the owner takes it again").isTrue();
        second.release().toCompletableFuture().join();
        assertThat(acquires(second)).as("a stranger has released nothing").isFalse();
        first.release().toCompletableFuture().join();
        assertThat(first.checkLease()).isFalse();
        assertThat(acquires(second)).isTrue();
        assertThat(acquires(lease(database, "node 2")))
                .as("another process at the address of the owner")
                .isFalse();
        second.release().toCompletableFuture().join();
    }

    /** The owner extends the lease: it is never free, although it lasts for 3 s only. */
    @Test
    void theLeaseOfAnOwnerThatIsLostEnds() throws Exception {
        String database = database();
        Lease owner = lease(database, "node 1", "3 s");
        assertThat(acquires(owner)).isTrue();
        String begun = until(database);
        while (until(database).equals(begun)) {
            Thread.onSpinWait(); // until the owner extends it
        }
        try (PostgresCatalog lost = catalog(database)) {
            owner.release().toCompletableFuture().join();
            assertThat(lost.takeLease("lab-pekko-sbr", "lost", Duration.ofSeconds(1))).isTrue();
        }
        Lease next = lease(database, "node 2");
        assertThat(acquires(next)).isTrue();
        assertThat(next.checkLease()).isTrue();
        next.release().toCompletableFuture().join();
    }

    private static String until(String database) throws Exception {
        return postgres.query(database, "SELECT lease_until FROM reve.lease").getFirst();
    }

    @Test
    void anOwnerLearnsThatItHasLostTheLease() throws Exception {
        String database = database();
        CompletableFuture<Optional<Throwable>> loss = new CompletableFuture<>();
        Lease owner = lease(database, "node 1");
        assertThat(owner.acquire(loss::complete).toCompletableFuture().join()).isTrue();
        postgres.execute(database, "UPDATE reve.lease SET owner = 'another'");
        assertThat(loss.join()).isEmpty();
        assertThat(owner.checkLease()).isFalse();
    }

    @Test
    void withoutTheDatabaseNobodyHasTheLease() throws Exception {
        String database = database();
        CompletableFuture<Optional<Throwable>> loss = new CompletableFuture<>();
        Lease owner = lease(database, "node 1", "3 s"); // its end is awaited
        assertThat(owner.acquire(loss::complete).toCompletableFuture().join()).isTrue();
        postgres.stop();
        try {
            assertThat(loss.join()).get().isInstanceOf(IOException.class);
            assertThat(owner.checkLease()).isFalse();
            assertThatExceptionOfType(CompletionException.class)
                    .isThrownBy(() -> acquires(lease(database, "node 2")))
                    .withMessageContaining(postgres.url(database));
        } finally {
            postgres.start();
        }
        Lease next = lease(database, "node 2");
        assertThat(acquires(next)).as("the lease of the first owner has ended").isTrue();
        next.release().toCompletableFuture().join();
    }

    @Test
    void aWorldIsAddedOnceAndMadeNoFrames() throws Exception {
        String database = database();
        Path pack = Files.createTempFile("reve-test-", ".zip");
        try (PostgresCatalog catalog = catalog(database)) {
            Files.writeString(pack, "the first pack");
            assertThat(catalog.add("w", pack)).isTrue();
            Files.writeString(pack, "another pack");
            assertThat(catalog.add("w", pack)).isFalse();
            assertThat(catalog.worlds())
                    .singleElement()
                    .satisfies(
                            world -> {
                                assertThat(world.name()).isEqualTo("w");
                                assertThat(world.epoch()).isZero();
                                assertThat(world.isOwned()).isFalse();
                                assertThat(world.frame()).isEqualTo(-1);
                            });
            PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
            assertThat(PostgresStore.pack(url, "w"))
                    .hasValueSatisfying(
                            bytes -> assertThat(new String(bytes)).isEqualTo("the first pack"));
            try (TakenStore taken =
                    new StoreAddress.InDatabase(url, "w", Optional.empty())
                            .take(SqliteStore.Durability.NORMAL, _ -> {})) {
                assertThat(taken.epoch()).hasValue(1);
                assertThat(taken.contents().isEmpty()).isTrue();
                assertThat(catalog.worlds())
                        .extracting(PostgresStore.World::isOwned)
                        .isEqualTo(List.of(true));
            }
        } finally {
            Files.delete(pack);
        }
    }

    @Test
    void ordersAboutPlacesAreForAllNodes() throws Exception {
        String database = database();
        try (PostgresCatalog one = catalog(database);
                PostgresCatalog other = catalog(database)) {
            assertThat(other.places()).isEqualTo(PostgresCatalog.Places.NONE);
            one.place("w1", Optional.of("a:1"));
            one.place("w1", Optional.of("b:2"));
            one.place("w2", Optional.of("a:1"));
            one.drain("a:1", true);
            one.drain("a:1", true);
            assertThat(other.places())
                    .isEqualTo(
                            new PostgresCatalog.Places(
                                    Map.of("w1", "b:2", "w2", "a:1"), Set.of("a:1")));
            other.place("w1", Optional.empty());
            other.drain("a:1", false);
            assertThat(one.places())
                    .isEqualTo(new PostgresCatalog.Places(Map.of("w2", "a:1"), Set.of()));
        }
    }

    private static PostgresCatalog.Report program(String version, int protocol, int oldest) {
        return new PostgresCatalog.Report(
                new PostgresCatalog.Program(version, protocol, oldest),
                new PostgresCatalog.Load("", 0.25, 0.5, 7));
    }

    /** The programs of all nodes understand each other. A lost node does not count for long. */
    @Test
    void aNodeWhoseProgramDoesNotFitIsRefused() throws Exception {
        String database = database();
        try (PostgresCatalog nodes = catalog(database)) {
            nodes.enter("a:1", program("1.0", 1, 1));
            nodes.enter("b:2", program("2.0", 2, 1));
            assertThat(nodes.reports())
                    .isEqualTo(Map.of("a:1", program("1.0", 1, 1), "b:2", program("2.0", 2, 1)));
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(() -> nodes.enter("c:3", program("3.0", 3, 2)))
                    .withMessage(
                            "the node a:1 runs REVE 1.0, which speaks version 1 between nodes and"
                                    + " understands no other one; this program is REVE 3.0, which"
                                    + " speaks version 3 between nodes and understands 2 to 3."
                                    + " Start a version that fits, or end all other nodes first");
            postgres.execute(
                    database,
                    "UPDATE reve.node SET reported = clock_timestamp() - interval '11 s' WHERE node"
                            + " = 'a:1'");
            nodes.enter("c:3", program("3.0", 3, 2));
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(() -> nodes.enter("a:1", program("1.0", 1, 1)))
                    .withMessageStartingWith("the node c:3 runs REVE 3.0");
            nodes.enter("a:1", program("2.1", 2, 2)); // at the address of an earlier one
            assertThat(nodes.reports()).hasSize(3);
        }
        try (PostgresCatalog ends = catalog(database)) {
            ends.leave("b:2");
        }
        try (PostgresCatalog nodes = catalog(database)) {
            assertThat(nodes.reports()).containsOnlyKeys("a:1", "c:3");
        }
    }

    /** Sessions belong to the state of a world after one frame, in one epoch. */
    @Test
    void sessionsAreForTheNextEpochAndTheSameFrame() throws Exception {
        String database = database();
        PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
        StoreAddress world = new StoreAddress.InDatabase(url, "w", Optional.empty());
        List<CarriedSession> sessions =
                List.of(
                        new CarriedSession("ada", OptionalLong.of(7), "{\"text\":\"\u0000'ä\"}"),
                        new CarriedSession("eye", OptionalLong.empty(), "{}"));
        assertThat(sessionsOf(world)).as("epoch 1").isEmpty();
        handOver(world, -1, sessions);
        assertThat(sessionsOf(world)).as("epoch 3").isEqualTo(sessions);
        assertThat(sessionsOf(world)).as("epoch 4").isEmpty();
        handOver(world, 12, sessions);
        assertThat(sessionsOf(world)).as("the world does not end with frame 12").isEmpty();
        handOver(world, -1, sessions);
        handOver(world, -1, List.of());
        assertThat(sessionsOf(world)).as("only those of the previous epoch").isEmpty();
    }

    private static CarriedSession session(String client, List<FinishedCommand> finished) {
        return new CarriedSession(
                client,
                OptionalLong.of(7),
                "{}",
                Optional.of(new CarriedSession.Since(finished, -1)));
    }

    private static void frame(JournalSink sink, long frame, SessionNote... notes)
            throws IOException {
        sink.note(List.of(notes));
        sink.write(new JournalRecord.Frame(frame, new byte[] {1}));
    }

    private static void image(JournalSink sink, long frame, SessionNote... notes)
            throws IOException {
        sink.note(List.of(notes));
        sink.place().write(List.of(), new JournalRecord.Image(frame, new byte[] {2}));
    }

    /** The sessions of a server that was lost are those after its last frame. */
    @Test
    void sessionsOfALostServerAreThoseOfItsLastFrame() throws Exception {
        String database = database();
        PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
        StoreAddress world = new StoreAddress.InDatabase(url, "w", Optional.empty());
        FinishedCommand accepted = new FinishedCommand(1, 2, "", "");
        FinishedCommand refused = new FinishedCommand(2, 0, "no-such-item", "it's \"gone\"");
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            assertThat(sink.keepsSessions()).isTrue();
            image(sink, 0);
            frame(sink, 1, new SessionNote.Began(session("ada", List.of())));
            frame(sink, 2, new SessionNote.Finished("ada", accepted));
            frame(sink, 3);
            frame(
                    sink,
                    4,
                    new SessionNote.Finished("ada", refused),
                    new SessionNote.Began(session("eve", List.of())));
            sink.note(List.of(new SessionNote.Ended("ada"))); // of a frame that is never written
        }
        List<CarriedSession> after =
                List.of(session("ada", List.of(accepted, refused)), session("eve", List.of()));
        assertThat(sessionsOf(world)).isEqualTo(after);
        assertThat(sessionsOf(world))
                .as("the server that took the world was lost before its first frame")
                .isEqualTo(after);
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            image(sink, 5, new SessionNote.Began(after.getFirst()));
            assertThat(rowsOfNotes(database)).as("older rows are removed").isEqualTo(1);
            frame(sink, 6, new SessionNote.Began(session("eve", List.of())));
            image(sink, 6);
            assertThat(rowsOfNotes(database)).isEqualTo(1);
            frame(sink, 7, new SessionNote.Ended("eve"));
        }
        assertThat(sessionsOf(world)).isEqualTo(List.of(after.getFirst()));
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            image(sink, 8);
        }
        assertThat(sessionsOf(world)).as("a server without notes had the world").isEmpty();
        assertThat(rowsOfNotes(database)).isZero();
    }

    /** Sessions that cannot be read are lost, which is reported. The world is not lost. */
    @Test
    void notesThatCannotBeReadLoseSessionsAndNotTheWorld() throws Exception {
        String database = database();
        PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
        StoreAddress world = new StoreAddress.InDatabase(url, "w", Optional.empty());
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            image(sink, 0, new SessionNote.Began(session("ada", List.of())));
            frame(sink, 1, new SessionNote.Began(session("eve", List.of())));
        }
        List<CarriedSession> both = List.of(session("ada", List.of()), session("eve", List.of()));
        assertThat(sessionsOf(world)).isEqualTo(both);
        String whole =
                postgres.query(database, "SELECT notes FROM reve.session_note WHERE frame = 1")
                        .getFirst();
        for (String damaged :
                List.of(
                        whole.replace("eve", "eva"),
                        "00000000:[]",
                        "",
                        "5",
                        "null",
                        "[{\"cli",
                        "[7]",
                        "[{\"client\":\"eve\",\"result\":[]}]")) {
            writeNotes(database, 1, damaged);
            requireLost(world, "the notes about sessions of frame 1 are damaged", List.of());
        }
        writeNotes(database, 1, whole);
        writeNotes(database, 0, "[7]");
        requireLost(
                world,
                "the notes about sessions of frame 0 are damaged",
                List.of(session("eve", List.of())));
    }

    /** A row of notes that is missing or moved would execute an act twice, or end sessions. */
    @Test
    void notesThatAreMissingOrMovedAreReported() throws Exception {
        String database = database();
        PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
        StoreAddress world = new StoreAddress.InDatabase(url, "w", Optional.empty());
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            image(sink, 0, new SessionNote.Began(session("ada", List.of())));
            frame(sink, 1, new SessionNote.Began(session("eve", List.of())));
        }
        List<CarriedSession> eve = List.of(session("eve", List.of()));
        postgres.execute(database, "CREATE TABLE kept AS SELECT * FROM reve.session_note");
        Map<String, List<CarriedSession>> left = new LinkedHashMap<>();
        left.put("DELETE FROM reve.session_note WHERE frame = 1", List.of());
        left.put("DELETE FROM reve.session_note WHERE frame = 0", eve);
        left.put("DELETE FROM reve.session_note", List.of());
        left.put("UPDATE reve.session_note SET frame = 1000 WHERE frame = 1", List.of());
        left.put("UPDATE reve.session_note SET frame = 1000 WHERE frame = 0", eve);
        left.put("UPDATE reve.session_note SET epoch = 2", List.of());
        left.put("UPDATE reve.session_note SET whole = NOT whole WHERE frame = 1", List.of());
        left.put("UPDATE reve.session_note SET whole = NOT whole WHERE frame = 0", eve);
        left.put(
                "UPDATE reve.session_note SET notes = (SELECT notes FROM kept WHERE frame = 0)",
                List.of());
        left.put(
                "UPDATE reve.session_note SET notes = (SELECT notes FROM kept WHERE frame = 1)",
                eve);
        for (Map.Entry<String, List<CarriedSession>> damage : left.entrySet()) {
            postgres.execute(
                    database,
                    "DELETE FROM reve.session_note; INSERT INTO reve.session_note SELECT * FROM"
                            + " kept; "
                            + damage.getKey());
            requireLost(world, "the notes about sessions of frame ", damage.getValue());
        }
    }

    /** What a server hands over is better than the notes, because it contains the events. */
    @Test
    void sessionsThatWereHandedOverAndCannotBeReadContinueFromTheNotes() throws Exception {
        String database = database();
        PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
        StoreAddress world = new StoreAddress.InDatabase(url, "w", Optional.empty());
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            image(sink, 0);
            frame(sink, 1, new SessionNote.Began(session("ada", List.of())));
        }
        handOver(world, 1, List.of(new CarriedSession("ada", OptionalLong.empty(), "{}")));
        postgres.execute(database, "UPDATE reve.session SET sessions = '[7]'");
        requireProblem(
                world,
                "the sessions that the previous server handed over at frame 1 are damaged",
                "they continue as the notes of this frame have them",
                List.of(session("ada", List.of())));
    }

    /** Databases of earlier versions have no column with a reference to the notes. */
    @Test
    void notesOfAnEarlierVersionContinue() throws Exception {
        String database = database();
        PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
        StoreAddress world = new StoreAddress.InDatabase(url, "w", Optional.empty());
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            image(sink, 0, new SessionNote.Began(session("ada", List.of())));
            frame(sink, 1, new SessionNote.Began(session("eve", List.of())));
        }
        postgres.execute(
                database,
                "ALTER TABLE reve.image DROP COLUMN notes;"
                        + " ALTER TABLE reve.frame DROP COLUMN notes");
        List<CarriedSession> both = List.of(session("ada", List.of()), session("eve", List.of()));
        assertThat(sessionsOf(world)).as("no node of this version has entered").isEqualTo(both);
        try (PostgresCatalog catalog = catalog(database)) {
            catalog.prepare();
        }
        assertThat(sessionsOf(world)).isEqualTo(both);
    }

    private static void writeNotes(String database, long frame, String notes) throws Exception {
        postgres.execute(
                database,
                "UPDATE reve.session_note SET notes = '" + notes + "' WHERE frame = " + frame);
    }

    /** Requires one message, and that all other sessions continue. */
    private static void requireLost(StoreAddress world, String message, List<CarriedSession> left)
            throws IOException {
        requireProblem(world, message, "join again", left);
    }

    private static void requireProblem(
            StoreAddress world, String message, String consequence, List<CarriedSession> left)
            throws IOException {
        List<String> problems = new ArrayList<>();
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, problems::add)) {
            assertThat(taken.sessions()).isEqualTo(left);
            taken.contents().requireWhole();
            assertThat(taken.contents().frame()).isEqualTo(1);
        }
        assertThat(problems)
                .singleElement()
                .asString()
                .startsWith(world + ": " + message)
                .contains(consequence);
    }

    private static int rowsOfNotes(String database) throws Exception {
        return Integer.parseInt(
                postgres.query(database, "SELECT count(*) FROM reve.session_note").getFirst());
    }

    private static List<CarriedSession> sessionsOf(StoreAddress world) throws IOException {
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {})) {
            return taken.sessions();
        }
    }

    private static void handOver(StoreAddress world, long frame, List<CarriedSession> sessions)
            throws IOException {
        try (TakenStore taken = world.take(SqliteStore.Durability.NORMAL, _ -> {});
                JournalSink sink = taken.open()) {
            sink.handOver(frame, sessions);
        }
    }
}
