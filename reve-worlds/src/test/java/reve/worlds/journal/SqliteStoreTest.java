package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.DriverManager;
import java.sql.SQLException;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Random;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import reve.core.store.CorruptException;
import reve.worlds.journal.SqliteStore.Durability;

class SqliteStoreTest {
    private static final long SEED = 20261121;
    private static final int FLIPS = Integer.getInteger("reve.test.flips", 200);
    private static final String SHA = "ab".repeat(32);

    @TempDir
    private Path folder;
    private Path file;
    private final List<String> problems = new ArrayList<>();

    @BeforeEach
    void name() {
        file = folder.resolve("my.db");
    }

    @Test
    void theNewestImageAndTheJournalAfterItComeBack() throws IOException {
        fill();
        try (SqliteStore store = new SqliteStore(file, Durability.FULL)) {
            assertThat(store.isEmpty()).isFalse();
            assertThat(describe(store.read(problems::add)))
                    .containsExactly("library " + SHA, "image 50", "frame 51", "frame 52");
            assertThat(problems).isEmpty();
        }
    }

    @Test
    void threeGenerationsAreKept() throws Exception {
        fill();
        assertThat(query("SELECT group_concat(frame) FROM image")).isEqualTo("30,40,50");
        assertThat(folder).isDirectoryContaining("glob:**/my.db-frames-3")
                .isDirectoryNotContaining("glob:**/my.db-frames-[12]");
    }

    @Test
    void aDamagedImageIsToldAndTheOneBeforeItTakenWithAllThatFollowed() throws Exception {
        fill();
        update("UPDATE image SET bytes = zeroblob(length(bytes)) WHERE frame = 50");
        try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
            assertThat(describe(store.read(problems::add))).containsExactly("library " + SHA,
                    "image 40", "frame 41", "frame 42", "frame 51", "frame 52");
            assertThat(problems).singleElement().asString().contains("my.db", "frame 50");
        }
    }

    @Test
    void aDamagedFrameIsToldAndEndsTheJournal() throws Exception {
        fill();
        Path last = folder.resolve("my.db-frames-5");
        byte[] damaged = Files.readAllBytes(last);
        damaged[damaged.length - 1]++;
        Files.write(last, damaged);
        assertThat(read()).containsExactly("library " + SHA, "image 50", "frame 51");
        assertThat(problems).singleElement().asString().contains("my.db-frames-5 is damaged");
    }

    @Test
    void aStoreThatIsRemovedIsToldAndMadeAnewWithTheNextImage() throws Exception {
        fill();
        try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
            Files.delete(file);
            JournalSink.Place place = store.place();
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(() -> place.write(List.of(), image(60)))
                    .withMessage(file + " was removed; it has been made anew");
            store.write(new JournalRecord.Frame(61, new byte[10]));
            store.place().write(List.of(), image(61));
            store.write(new JournalRecord.Frame(62, new byte[10]));
        }
        assertThat(read()).containsExactly("image 61", "frame 62");
    }

    @Test
    void withoutAnyGoodImageTheStoreIsRefused() throws Exception {
        fill();
        update("UPDATE image SET crc32c = crc32c + 1");
        try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
            assertThatExceptionOfType(CorruptException.class)
                    .isThrownBy(() -> store.read(problems::add))
                    .withMessageContaining("my.db holds no image that can be read");
            assertThat(problems).hasSize(3);
        }
    }

    /** Found, told, or without any effect: never other records in silence. */
    @Test
    void noFlippedBitChangesWhatIsReadInSilence() throws IOException {
        fill();
        byte[] whole = Files.readAllBytes(file);
        List<String> expected;
        try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
            expected = contents(store.read(problems::add));
        }
        Random random = new Random(SEED);
        for (int i = 0; i < FLIPS; i++) {
            int bit = random.nextInt(8 * whole.length);
            byte[] flipped = whole.clone();
            flipped[bit / 8] ^= (byte) (1 << bit % 8);
            Files.write(file, flipped);
            Files.deleteIfExists(folder.resolve("my.db-wal"));
            problems.clear();
            try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
                List<String> found = contents(store.read(problems::add));
                assertThat(found.equals(expected) || !problems.isEmpty())
                        .as("bit %d of %d, seed %d", bit, 8 * whole.length, SEED).isTrue();
            } catch (CorruptException | IOException refused) {
                assertThat(refused).hasMessageContaining("my.db");
            }
        }
    }

    /** Read whole, told, refused by name, or (an empty file) a new store. */
    @Test
    void aStoreThatIsCutIsNeverReadAsAnotherInSilence() throws IOException {
        fill();
        byte[] whole = Files.readAllBytes(file);
        List<String> expected = read();
        Random random = new Random(SEED);
        for (int i = 0; i < FLIPS / 4; i++) {
            int length = i == 0 ? 0 : random.nextInt(whole.length);
            Files.write(file, Arrays.copyOf(whole, length));
            Files.deleteIfExists(folder.resolve("my.db-wal"));
            problems.clear();
            try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
                assertThat(length == 0 ? store.isEmpty()
                        : describe(store.read(problems::add)).equals(expected)
                                || !problems.isEmpty())
                        .as("cut at byte %d, seed %d", length, SEED).isTrue();
            } catch (CorruptException | IOException refused) {
                assertThat(refused).hasMessageContaining("my.db");
            }
        }
    }

    @Test
    void whatIsNoStoreIsRefusedAndLeftAsItIs() throws Exception {
        Files.writeString(file, "Dear diary, this is no database at all.");
        refused("my.db is no store of REVE");
        assertThat(Files.readString(file)).startsWith("Dear diary");
        Files.delete(file);
        update("CREATE TABLE diary (entry TEXT)");
        refused("no store of REVE");
        assertThat(query("SELECT count(*) FROM diary")).isEqualTo("0");
    }

    @Test
    void aStoreOfANewerVersionIsRefused() throws Exception {
        fill();
        update("PRAGMA user_version = 7");
        refused("version 7");
    }

    @Test
    void aStoreThatIsOpenElsewhereIsRefused() throws Exception {
        fill();
        try (SqliteStore open = new SqliteStore(file, Durability.NORMAL)) {
            assertThat(open.isEmpty()).isFalse();
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(() -> new SqliteStore(file, Durability.NORMAL))
                    .withMessageContainingAll("my.db", "locked", "in use by another process",
                            "name another file");
        }
    }

    private void refused(String message) {
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> new SqliteStore(file, Durability.NORMAL))
                .withMessageContaining(message);
    }

    private List<String> read() throws IOException {
        try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
            return describe(store.read(problems::add));
        }
    }

    private static JournalRecord.Image image(long frame) {
        return new JournalRecord.Image(frame, new byte[100]);
    }

    /** Images of the frames 10 to 50 with two frames after each. */
    private void fill() throws IOException {
        Random random = new Random(SEED);
        try (SqliteStore store = new SqliteStore(file, Durability.NORMAL)) {
            assertThat(store.isEmpty()).isTrue();
            var library = new JournalRecord.Library(SHA, bytes(random, 3000));
            for (int frame = 10; frame <= 50; frame += 10) {
                store.place().write(List.of(library),
                        new JournalRecord.Image(frame, bytes(random, 6000)));
                store.write(new JournalRecord.Frame(frame + 1, bytes(random, 200)));
                store.write(new JournalRecord.Frame(frame + 2, bytes(random, 200)));
            }
        }
    }

    private static byte[] bytes(Random random, int count) {
        byte[] bytes = new byte[count];
        random.nextBytes(bytes);
        return bytes;
    }

    private static List<String> describe(List<JournalRecord> records) {
        return records.stream().map(record -> switch (record) {
            case JournalRecord.Library library -> "library " + library.sha256();
            case JournalRecord.Image image -> "image " + image.frame();
            case JournalRecord.Frame frame -> "frame " + frame.frame();
        }).toList();
    }

    /** Libraries are checked by their SHA-256 when they are loaded. */
    private static List<String> contents(List<JournalRecord> records) {
        return records.stream().filter(record -> !(record instanceof JournalRecord.Library))
                .map(record -> switch (record) {
                    case JournalRecord.Library library -> "";
                    case JournalRecord.Image image ->
                            image.frame() + " " + Arrays.hashCode(image.bytes());
                    case JournalRecord.Frame frame ->
                            frame.frame() + " " + Arrays.hashCode(frame.json());
                }).toList();
    }

    private void update(String sql) throws SQLException {
        try (Connection connection = DriverManager.getConnection("jdbc:sqlite:" + file);
                var statement = connection.createStatement()) {
            statement.executeUpdate(sql);
        }
    }

    private String query(String sql) throws SQLException {
        try (Connection connection = DriverManager.getConnection("jdbc:sqlite:" + file);
                var statement = connection.createStatement();
                var result = statement.executeQuery(sql)) {
            result.next();
            return result.getString(1);
        }
    }
}
