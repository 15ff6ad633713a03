// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.image.CorruptException;
import reve.worlds.journal.SqliteStore.Durability;

import java.io.IOException;
import java.lang.reflect.Field;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.StandardCopyOption;
import java.nio.file.StandardOpenOption;
import java.sql.Connection;
import java.sql.DriverManager;
import java.sql.SQLException;
import java.sql.Statement;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.UUID;
import java.util.stream.Stream;

@Tag("slow")
class SqliteStoreTest {
    private static final long SEED = 20261121;
    private static final int FLIPS = Integer.getInteger("reve.test.flips", 200);
    private static final int CUT_STEP = Integer.getInteger("reve.test.cut.step", 7);
    private static final byte[] LIBRARY = bytes(new Random(SEED), 3000);
    private static final String SHA = StoreDatabase.sha256(LIBRARY);

    @TempDir private Path folder;
    private Path file;
    private final List<String> problems = new ArrayList<>();

    @BeforeEach
    void name() {
        file = folder.resolve("my.db");
    }

    @Test
    void theNewestImageAndTheJournalAfterItComeBack() throws IOException {
        fill();
        assertThat(read()).containsExactly("library " + SHA, "image 22", "frame 23", "frame 24");
        assertThat(problems).isEmpty();
    }

    @Test
    void threeGenerationsAreKept() throws Exception {
        fill();
        assertThat(query("SELECT group_concat(frame) FROM image")).isEqualTo("16,19,22");
        assertThat(folder)
                .isDirectoryContaining("glob:**/my.db-frames-3")
                .isDirectoryNotContaining("glob:**/my.db-frames-[12]");
    }

    @Test
    void aDamagedImageIsToldAndTheOneBeforeItTakenWithAllThatFollowed() throws Exception {
        fill();
        update("UPDATE image SET bytes = zeroblob(length(bytes)) WHERE frame = 22");
        assertThat(read())
                .containsExactly(
                        "library " + SHA,
                        "image 19",
                        "frame 20",
                        "frame 21",
                        "frame 22",
                        "frame 23",
                        "frame 24");
        assertThat(problems).singleElement().asString().contains("my.db", "frame 22");
    }

    @Test
    void aPipeInPlaceOfAFileIsRefused() throws Exception {
        fill();
        for (String name : List.of("my.db-journal", "my.db-manifest", "my.db-frames-5", "my.db")) {
            Path pipe = folder.resolve(name);
            Files.deleteIfExists(pipe);
            assertThat(new ProcessBuilder("mkfifo", pipe.toString()).start().waitFor()).isZero();
            assertThatThrownBy(this::read)
                    .isInstanceOf(IOException.class)
                    .hasMessageContaining(pipe + " is a device or a pipe");
            Files.delete(pipe);
        }
    }

    /** Another program made the link while the store was open. */
    @Test
    void theNextFileOfFramesIsNotWrittenThroughALink() throws Exception {
        Path other = Files.writeString(folder.resolve("other"), "precious");
        try (SqliteStore store = open(file)) {
            for (int number = 1; number < 4; number++) {
                Path next = folder.resolve("my.db-frames-" + number);
                if (!Files.exists(next)) {
                    Files.createSymbolicLink(next, other);
                }
            }
            assertThatThrownBy(() -> store.place().write(List.of(), image(10)))
                    .isInstanceOf(IOException.class)
                    .hasMessageContaining("is no regular file");
        }
        assertThat(other).hasContent("precious");
    }

    @Test
    void aNameThatBelongsToAnotherStoreOrHoldsOptionsIsRefused() {
        for (String name : List.of("my.db-wal", "my.db-shm", "my.db-journal", "my.db-frames-7")) {
            assertThatThrownBy(() -> StoreContents.read(folder.resolve(name)))
                    .isInstanceOf(IOException.class)
                    .hasMessageContaining("belongs to another store");
        }
        assertThatThrownBy(() -> StoreContents.read(folder.resolve("my.db?journal_mode=off")))
                .isInstanceOf(IOException.class)
                .hasMessageContaining("contains a question mark");
        assertThat(folder).isEmptyDirectory();
    }

    @Test
    void aNameThatLeavesNoRoomForTheNumbersOfFilesIsRefused() throws Exception {
        for (int length : new int[] {238, 246, 255, 300}) {
            Path named = folder.resolve("a".repeat(length));
            assertThatThrownBy(() -> open(named))
                    .isInstanceOf(IOException.class)
                    .hasMessageContainingAll(
                            named + " could not be opened: its name is too long",
                            "NAME-frames-9999999999; take a shorter name");
        }
        assertThat(folder).isEmptyDirectory();
        open(folder.resolve("a".repeat(237))).close();
    }

    /** The store has the files of a process that was killed while it created the store. */
    @Test
    void aDatabaseWithoutContentIsAnEmptyStore() throws Exception {
        update("PRAGMA journal_mode = WAL");
        assertThat(Files.size(file)).isPositive();

        fill();

        assertThat(read()).contains("image 22", "frame 24");
        assertThat(query("PRAGMA user_version")).isEqualTo("" + StoreDatabase.VERSION);
    }

    /**
     * The process was killed before it removed the rollback journal of the first write, which
     * reverts the database to an empty file.
     */
    @Test
    void aJournalFromTheCreationOfTheStoreIsApplied() throws Exception {
        update("PRAGMA journal_mode = WAL");
        byte[] journal =
                ByteBuffer.allocate(512)
                        .putLong(0xd9d505f920a163d7L) // the format's magic
                        .putInt(0) // pages in the journal
                        .putInt(4711) // nonce
                        .putInt(0) // pages of the database before the write
                        .putInt(512) // size of a sector
                        .putInt(4096) // size of a page
                        .array();
        Files.write(StoreDatabase.rollback(file), journal);

        assertThat(StoreContents.read(file).isEmpty()).isTrue();
        fill();

        assertThat(read()).contains("image 22", "frame 24");
    }

    /** SQLite itself reverts a write when there is no room for it. */
    @Test
    void imagesAreWrittenAgainWhenThereIsRoomAgain() throws Exception {
        try (SqliteStore store = open(file)) {
            store.place().write(List.of(), image(1));
            limit(store, 5);
            var large = new JournalRecord.Image(2, new byte[1 << 20]);
            assertThatThrownBy(() -> store.place().write(List.of(), large))
                    .isInstanceOf(IOException.class)
                    .hasMessageContaining("could not be written");
            limit(store, 1 << 30);
            store.place().write(List.of(), image(3));
        }
        assertThat(read()).containsExactly("image 3");
    }

    private static void limit(SqliteStore store, int pages) throws Exception {
        Field connection = SqliteStore.class.getDeclaredField("connection");
        connection.setAccessible(true);
        try (Statement statement = ((Connection) connection.get(store)).createStatement()) {
            statement.execute("PRAGMA max_page_count = " + pages);
        } catch (SQLException closed) {
            // the next write opens another connection, which has no limit
        }
    }

    /** After a regular end, the last image contains the edits after the last frame. */
    @Test
    void aDamagedLastImageIsRefusedAlthoughAllFramesAreThere() throws Exception {
        fill();
        try (SqliteStore store = open(file)) {
            store.place().write(List.of(), image(24));
        }
        update("UPDATE image SET bytes = zeroblob(1) WHERE frames_file = 6");
        refused("the last image, of frame 24, cannot be used");
    }

    /** The message names the file, and the last frame before the cut. */
    @Test
    void aFileOfFramesThatIsCutAnywhereIsRefusedByTheFrameThatIsLost() throws IOException {
        fill();
        Path last = folder.resolve("my.db-frames-5");
        byte[] whole = Files.readAllBytes(last);
        for (int length = whole.length - 1; length >= 0; length -= CUT_STEP) {
            Files.write(last, Arrays.copyOf(whole, length));
            refused("my.db-frames-5");
            refused("can continue from frame 2");
            assertThat(Files.size(last)).isEqualTo(length);
        }
        Files.write(last, whole);
        assertThat(read()).contains("frame 24");
    }

    /**
     * The manifest is written after the frame. Therefore it never announces an incomplete record.
     */
    @Test
    void anUnfinishedLastRecordIsLostInSilence() throws IOException {
        fill();
        Path last = folder.resolve("my.db-frames-5");
        byte[] whole = Files.readAllBytes(last);
        for (int more = 1; more < 60; more++) {
            byte[] torn = Arrays.copyOf(whole, whole.length + more);
            System.arraycopy(whole, RunLog.LINKED_BYTES, torn, whole.length, more);
            Files.write(last, torn);
            assertThat(read()).endsWith("frame 24");
            assertThat(problems).isEmpty();
        }
    }

    @Test
    void noFlippedBitInAFileBesideIsReadInSilence() throws IOException {
        fill();
        List<String> expected = read();
        for (String name : List.of("my.db-frames-5", "my.db-frames-4", "my.db-manifest")) {
            Path damaged = folder.resolve(name);
            byte[] whole = Files.readAllBytes(damaged);
            for (int bit = 0; bit < 8 * whole.length; bit += 1 + 8 * whole.length / FLIPS) {
                byte[] flipped = whole.clone();
                flipped[bit / 8] ^= (byte) (1 << bit % 8);
                Files.write(damaged, flipped);
                String which = name + ", bit " + bit;
                try {
                    assertThat(read()).as(which).isEqualTo(expected);
                    assertThat(problems).as(which).isNotEmpty();
                } catch (CorruptException refused) {
                    assertThat(refused)
                            .as(which)
                            .hasMessageContaining(damaged.toString())
                            .hasMessageContaining("nothing was changed");
                }
                assertThat(Files.readAllBytes(damaged)).as(which).isEqualTo(flipped);
            }
            Files.write(damaged, whole);
        }
    }

    @Test
    void aStoreWithoutItsDatabaseIsRefusedAndKept() throws IOException {
        fill();
        Files.delete(file);
        refused("my.db is missing, but " + folder.resolve("my.db-frames-3"));
        Files.createFile(file);
        refused("my.db is empty, but");
        assertThat(folder).isDirectoryContaining("glob:**/my.db-frames-3");
    }

    @Test
    void aFileOfAnotherStoreIsRefusedByName() throws IOException {
        Path other = folder.resolve("other.db");
        fill();
        fill(other, SEED + 1);
        for (String name : List.of("-frames-5", "-frames-4", "-manifest", "")) {
            Path own = folder.resolve("my.db" + name);
            byte[] whole = Files.readAllBytes(own);
            Files.copy(folder.resolve("other.db" + name), own, StandardCopyOption.REPLACE_EXISTING);
            refused("another store than");
            Files.write(own, whole);
        }
        assertThat(read()).endsWith("frame 24");
    }

    /** Two runs that continue from copies of one store have the same identity but diverge. */
    @Test
    void aFileOfAnotherCopyOfTheStoreIsRefusedByName() throws IOException {
        fill();
        Path copies = Files.createDirectory(folder.resolve("copies"));
        for (Path each : StoreContents.read(file).files()) {
            Files.copy(each, copies.resolve(each.getFileName()));
        }
        goOn(file);
        goOn(copies.resolve("my.db"));
        for (String name : List.of("-frames-6", "")) {
            Path own = folder.resolve("my.db" + name);
            byte[] whole = Files.readAllBytes(own);
            Files.copy(copies.resolve("my.db" + name), own, StandardCopyOption.REPLACE_EXISTING);
            refused("another copy of the store");
            Files.write(own, whole);
        }
    }

    @Test
    void anOlderDatabaseIsMadeUpForByTheFramesOrRefused() throws Exception {
        fill();
        byte[] older = Files.readAllBytes(file);
        Path frames = folder.resolve("my.db-frames-5");
        byte[] before = Files.readAllBytes(frames);
        goOn(file);
        Files.write(frames, before);
        byte[] newer = Files.readAllBytes(file);
        Files.write(file, older);
        refused("my.db lacks the image of frame 25");
        Files.write(file, newer);
        update("DELETE FROM image WHERE frame = 22");
        assertThat(read()).endsWith("frame 27");
    }

    /**
     * The manifest names fewer frames than the store had. Therefore the newest frames may be
     * missing.
     */
    @Test
    void anOlderManifestIsRefusedAsAMissingOneIs() throws Exception {
        fill();
        byte[] older = Files.readAllBytes(Manifest.path(file));
        goOn(file);
        Path last = folder.resolve("my.db-frames-6");
        byte[] frames = Files.readAllBytes(last);
        Files.write(Manifest.path(file), older);
        refused("my.db-manifest is older than " + file + ", so the newest frames may be missing");
        Files.write(last, Arrays.copyOf(frames, frames.length / 2));
        refused("my.db-manifest is older than " + file);
        Files.delete(last);
        refused("my.db-manifest is older than " + file);
        refused("my.db-frames-6 is missing");
        update("DELETE FROM image WHERE frame = 25");
        Files.write(last, frames);
        refused("my.db-manifest is older than " + last);
    }

    /** The states that a killed process leaves between two writes of the manifest. */
    @Test
    void aKillBetweenTheManifestAndTheDatabaseLosesNothing() throws IOException {
        fill();
        byte[] before = Files.readAllBytes(Manifest.path(file));
        byte[] begun;
        byte[] reached;
        try (SqliteStore store = open(file)) {
            JournalSink.Place place = store.place();
            begun = Files.readAllBytes(Manifest.path(file));
            place.write(List.of(), image(25));
            for (int frame = 26; frame < 28; frame++) {
                store.write(new JournalRecord.Frame(frame, new byte[20]));
            }
            JournalSink.Place next = store.place();
            store.write(new JournalRecord.Frame(28, new byte[20]));
            reached = Files.readAllBytes(Manifest.path(file));
            next.write(List.of(), image(27));
        }
        Files.write(Manifest.path(file), reached);
        assertThat(read()).endsWith("image 27", "frame 28");
        assertThat(problems).isEmpty();

        Path copies = Files.createDirectory(folder.resolve("copies"));
        file = copies.resolve("my.db");
        fill();
        byte[] old = Files.readAllBytes(Manifest.path(file));
        try (SqliteStore store = open(file)) {
            store.place();
        }
        assertThat(read()).endsWith("frame 24");
        Files.write(Manifest.path(file), old);
        assertThat(read()).endsWith("frame 24");
        assertThat(problems).isEmpty();
        assertThat(before).isNotEqualTo(begun);
    }

    @Test
    void afterAPowerFailureAShorterLastFileIsToldAndTaken() throws IOException {
        fill();
        Path last = folder.resolve("my.db-frames-5");
        byte[] whole = Files.readAllBytes(last);
        Files.write(last, Arrays.copyOf(whole, whole.length - 3));
        refused("my.db-frames-5");
        startTheMachineAgain();
        assertThat(read()).endsWith("frame 23");
        assertThat(problems)
                .singleElement()
                .asString()
                .contains("my.db-frames-5 ends at frame 23 of 24", "started again");
    }

    /** The file can lack its directory entry, its content, or the end of the file before it. */
    @Test
    void afterAPowerFailureAFileThatWasJustBegunMayBeMissing() throws IOException {
        fill();
        try (SqliteStore store = open(file)) {
            store.place(); // begins a file for the next image
        }
        Path begun = folder.resolve("my.db-frames-6");
        Path last = folder.resolve("my.db-frames-5");
        byte[] whole = Files.readAllBytes(last);
        byte[] empty = Files.readAllBytes(begun);
        byte[] manifest = Files.readAllBytes(Manifest.path(file));
        byte[] torn = Arrays.copyOf(whole, whole.length - 3);
        for (Optional<byte[]> next : List.of(Optional.<byte[]>empty(), Optional.of(empty))) {
            for (byte[] content : List.of(whole, torn)) {
                Files.write(Manifest.path(file), manifest);
                Files.write(last, content);
                Files.deleteIfExists(begun);
                if (next.isPresent()) {
                    Files.write(begun, next.get());
                }
                if (content == torn) {
                    refused("my.db-frames-6" + (next.isEmpty() ? " is missing" : " ends at"));
                }
                startTheMachineAgain();
                assertThat(read()).endsWith(content == torn ? "frame 23" : "frame 24");
            }
        }
        Files.write(last, torn);
        Files.delete(begun);
        try (SqliteStore store = open(file)) {
            keep(store, 30);
        }
        assertThat(read()).endsWith("image 30");
    }

    private void startTheMachineAgain() throws IOException {
        Manifest.Claim now = Manifest.read(file).orElseThrow();
        new Manifest(
                        file,
                        new Manifest.Claim(
                                now.store(),
                                new UUID(1, 2),
                                now.file(),
                                now.fileId(),
                                now.frame(),
                                now.image(),
                                now.imageFrame(),
                                now.imageSum()))
                .close();
    }

    /** Version 2 wrote stores without identity, manifest and links. */
    @Test
    void anOldStoreIsReadAsBeforeAndGetsAnIdentityWhenItIsWritten() throws Exception {
        fill();
        update("DROP TABLE identity");
        update("PRAGMA user_version = 2");
        Files.delete(Manifest.path(file));
        for (Path each : FrameFiles.present(file).values()) {
            byte[] linked = Files.readAllBytes(each);
            byte[] old =
                    Arrays.copyOf(linked, linked.length - RunLog.LINKED_BYTES + RunLog.EMPTY_BYTES);
            System.arraycopy(
                    linked,
                    RunLog.LINKED_BYTES,
                    old,
                    RunLog.EMPTY_BYTES,
                    linked.length - RunLog.LINKED_BYTES);
            Files.write(each, old);
        }
        assertThat(read()).endsWith("image 22", "frame 23", "frame 24");
        assertThat(problems).isEmpty();
        goOn(file);
        assertThat(query("PRAGMA user_version")).isEqualTo("3");
        assertThat(read()).endsWith("image 25", "frame 26", "frame 27");
        Files.delete(folder.resolve("my.db-frames-6"));
        refused("my.db-frames-6 is missing");
    }

    @Test
    void aStoreThatIsRemovedIsToldAndMadeAnewWithTheNextImage() throws Exception {
        fill();
        try (SqliteStore store = open(file)) {
            Files.delete(file);
            JournalSink.Place place = store.place();
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(() -> place.write(List.of(), image(60)))
                    .withMessage(file + " was removed; it was created again");
            store.write(new JournalRecord.Frame(61, new byte[10]));
            store.place().write(List.of(), image(61));
            store.write(new JournalRecord.Frame(62, new byte[10]));
        }
        assertThat(read()).containsExactly("image 61", "frame 62");
    }

    /**
     * This happens while a server runs. There is one message for each file, and the next image
     * repairs the loss.
     */
    @Test
    void filesThatAreRemovedReplacedOrCutAreToldAndMadeUpForByTheNextImage() throws Exception {
        interface Act {
            void on(Path path) throws IOException;
        }
        Map<String, Act> acts = new LinkedHashMap<>();
        acts.put("was removed", Files::delete);
        acts.put(
                "was replaced by another file",
                path ->
                        Files.move(
                                Files.copy(
                                        path,
                                        folder.resolve("copy"),
                                        StandardCopyOption.REPLACE_EXISTING),
                                path,
                                StandardCopyOption.REPLACE_EXISTING));
        acts.put("was cut to ", path -> Files.write(path, new byte[3]));
        int run = 0;
        for (Map.Entry<String, Act> act : acts.entrySet()) {
            for (String name : List.of("-manifest", "-frames-6", "")) {
                file = Files.createDirectory(folder.resolve("run" + run++)).resolve("my.db");
                fill();
                Path path = file.resolveSibling("my.db" + name);
                try (SqliteStore store = open(file)) {
                    keep(store, 25);
                    store.write(new JournalRecord.Frame(26, new byte[20]));
                    assertThat(store.troubles()).isEmpty();
                    act.getValue().on(path);
                    if (name.startsWith("-frames")) { // a truncated file must not get a hole
                        store.write(new JournalRecord.Frame(27, new byte[20]));
                    }
                    assertThat(store.troubles())
                            .singleElement()
                            .asString()
                            .startsWith(path + " " + act.getKey())
                            .contains("The next image makes the store whole again");
                    assertThat(store.troubles()).isEmpty();
                    keep(store, 27);
                    assertThat(store.troubles()).isEmpty();
                    store.write(new JournalRecord.Frame(28, new byte[20]));
                }
                boolean isMoved = name.isEmpty() && act.getKey().startsWith("was replaced");
                boolean isKept = name.isEmpty() && act.getKey().startsWith("was cut");
                assertThat(Files.exists(file.resolveSibling("my.db.replaced-1"))).isEqualTo(isKept);
                assertThat(Files.exists(file.resolveSibling("my.db.moved-1"))).isEqualTo(isMoved);
                file = isMoved ? file.resolveSibling("my.db.moved-1") : file;
                assertThat(read()).as(path + " " + act.getKey()).endsWith("image 27", "frame 28");
            }
        }
    }

    /** An example is a file system that is unmounted and mounted again. */
    @Test
    void aFolderThatIsAwayForAnImageCostsTheFramesUntilItIsBack() throws Exception {
        Path home = Files.createDirectory(folder.resolve("home"));
        Path away = folder.resolve("away");
        file = home.resolve("my.db");
        fill();
        try (SqliteStore store = open(file)) {
            keep(store, 25);
            store.write(new JournalRecord.Frame(26, new byte[10]));
            Files.move(home, away);
            for (int image : new int[] {30, 31}) {
                assertThatExceptionOfType(IOException.class)
                        .isThrownBy(() -> keep(store, image))
                        .withMessageContaining(home.toString());
            }
            Files.move(away, home);
            keep(store, 40);
            store.write(new JournalRecord.Frame(41, new byte[10]));
            assertThat(store.troubles()).isEmpty();
        }
        assertThat(read()).endsWith("image 40", "frame 41");
    }

    /** An operator restores a copy of the store while the server that uses it still runs. */
    @Test
    void twoServersNeverWriteToEachOthersFiles() throws Exception {
        fill();
        Path backup = Files.createDirectory(folder.resolve("backup"));
        copyStore(folder, backup);
        try (SqliteStore one = open(file)) {
            keep(one, 25);
            one.write(new JournalRecord.Frame(26, new byte[10]));
            for (Path part : storeFiles(folder)) {
                Files.delete(part);
            }
            copyStore(backup, folder);
            try (SqliteStore other = open(file)) {
                keep(other, 30);
                other.write(new JournalRecord.Frame(31, new byte[10]));
                JournalSink.Place place = one.place();
                assertThatExceptionOfType(JournalSink.BegunAnewException.class)
                        .isThrownBy(() -> place.write(List.of(), image(60)))
                        .withMessageContaining("my.db was replaced by another file")
                        .withMessageContaining("my.db.moved-1 from now on");
                place.write(List.of(), image(60));
                one.write(new JournalRecord.Frame(61, new byte[10]));
                keep(other, 40);
                other.write(new JournalRecord.Frame(41, new byte[10]));
                keep(one, 70);
                one.write(new JournalRecord.Frame(71, new byte[10]));
                assertThat(other.troubles()).isEmpty();
                assertThat(one.troubles()).isEmpty();
            }
        }
        assertThat(read()).endsWith("image 40", "frame 41");
        file = folder.resolve("my.db.moved-1");
        assertThat(read()).containsExactly("image 70", "frame 71");
    }

    private static List<Path> storeFiles(Path in) throws IOException {
        try (Stream<Path> files = Files.list(in)) {
            return files.filter(Files::isRegularFile).toList();
        }
    }

    private static void copyStore(Path from, Path to) throws IOException {
        for (Path part : storeFiles(from)) {
            Files.copy(part, to.resolve(part.getFileName()));
        }
    }

    private static void keep(SqliteStore store, long frame) throws IOException {
        JournalSink.Place place = store.place();
        try {
            place.write(List.of(), image(frame));
        } catch (JournalSink.BegunAnewException e) {
            place.write(List.of(), image(frame));
        }
    }

    @Test
    void withoutAnyGoodImageTheStoreIsRefused() throws Exception {
        fill();
        update("UPDATE image SET crc32c = crc32c + 1");
        refused("my.db holds no image that can be read");
    }

    /**
     * A flipped bit is found, or is reported, or has no effect. The store never returns other
     * records without a report.
     */
    @Test
    void noFlippedBitChangesWhatIsReadInSilence() throws IOException {
        fill();
        byte[] whole = Files.readAllBytes(file);
        List<String> expected = contents();
        Random random = new Random(SEED);
        for (int i = 0; i < FLIPS; i++) {
            int bit = random.nextInt(8 * whole.length);
            byte[] flipped = whole.clone();
            flipped[bit / 8] ^= (byte) (1 << bit % 8);
            Files.write(file, flipped);
            String which = "bit %d of %d, seed %d".formatted(bit, 8 * whole.length, SEED);
            try {
                assertThat(contents().equals(expected) || !problems.isEmpty()).as(which).isTrue();
            } catch (CorruptException | IOException refused) {
                assertThat(refused).hasMessageContaining("my.db");
            }
            assertThat(Files.readAllBytes(file)).as(which).isEqualTo(flipped);
        }
    }

    /**
     * A store that is cut is read completely, or the loss is reported, or the store is refused by
     * name.
     */
    @Test
    void aStoreThatIsCutIsNeverReadAsAnotherInSilence() throws IOException {
        fill();
        byte[] whole = Files.readAllBytes(file);
        List<String> expected = read();
        Random random = new Random(SEED);
        for (int i = 0; i < FLIPS / 4; i++) {
            int length = i == 0 ? 0 : random.nextInt(whole.length);
            Files.write(file, Arrays.copyOf(whole, length));
            try {
                assertThat(read().equals(expected) || !problems.isEmpty())
                        .as("cut at byte %d, seed %d", length, SEED)
                        .isTrue();
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

    /**
     * The schema has endless views, other objects that run SQL, or objects that this program does
     * not create.
     */
    @Test
    void aDatabaseWithAnotherSchemaIsRefusedBeforeItIsRead() throws Exception {
        fill();
        byte[] whole = Files.readAllBytes(file);
        String endless = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT ";
        Map<String, List<String>> changes = new LinkedHashMap<>();
        for (String table : List.of("identity", "image", "library")) {
            changes.put(
                    "has a table old",
                    List.of(
                            "ALTER TABLE " + table + " RENAME TO old",
                            "CREATE VIEW "
                                    + table
                                    + " AS "
                                    + endless
                                    + "old.* FROM old, c WHERE c.x < 0"));
            changesRefused(changes, whole);
        }
        changes.put("has a view v", List.of("CREATE VIEW v AS " + endless + "x FROM c"));
        changes.put(
                "has a trigger t",
                List.of("CREATE TRIGGER t AFTER INSERT ON image BEGIN DELETE FROM library; END"));
        changes.put("has a index i", List.of("CREATE INDEX i ON image (frame)"));
        changes.put("has a table w", List.of("CREATE VIRTUAL TABLE w USING fts5(x)"));
        changes.put(
                "has a table image of another form",
                List.of("ALTER TABLE image ADD COLUMN more AS (zeroblob(1000000000))"));
        changes.put(
                "has a table library of another form",
                List.of(
                        "DROP TABLE library",
                        "CREATE TABLE library (sha256 TEXT PRIMARY KEY, bytes BLOB CHECK (bytes >"
                                + " 0))"));
        changes.put("lacks the table identity", List.of("DROP TABLE identity"));
        changes.put("has a table identity", List.of("PRAGMA user_version = 2"));
        changes.put(
                "is damaged so that nothing of it can be read",
                List.of("CREATE VIEW long AS " + "SELECT '" + "a".repeat(100_000) + "'"));
        changesRefused(changes, whole);
    }

    private void changesRefused(Map<String, List<String>> changes, byte[] whole) throws Exception {
        for (Map.Entry<String, List<String>> change : changes.entrySet()) {
            Files.write(file, whole);
            for (String sql : change.getValue()) {
                update(sql);
            }
            byte[] changed = Files.readAllBytes(file);
            refused("my.db " + change.getKey());
            assertThat(Files.readAllBytes(file)).isEqualTo(changed);
        }
    }

    /** A sparse file can have any size, so it must not be read. */
    @Test
    void aManifestOfAnotherSizeIsRefusedWithoutBeingRead() throws IOException {
        fill();
        try (var channel = FileChannel.open(Manifest.path(file), StandardOpenOption.WRITE)) {
            channel.write(ByteBuffer.allocate(1), (40L << 30) - 1);
        }
        refused("my.db-manifest is damaged: it has 42949672960 bytes, expected 106");
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
        try (SqliteStore _ = open(file)) {
            assertThatExceptionOfType(IOException.class)
                    .isThrownBy(() -> StoreContents.read(file))
                    .withMessageContainingAll(
                            "my.db", "locked", "in use by another process", "name another file");
        }
    }

    @Test
    void whatSqliteCannotOpenIsNamedInWords() throws Exception {
        fill();
        Path log = folder.resolve("my.db-wal");
        Files.deleteIfExists(log);
        Files.createDirectory(log);
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(() -> StoreContents.read(file))
                .withMessageStartingWith(
                        file
                                + " could not be opened: "
                                + log
                                + " is a folder, expected a file of the database or nothing");
        Files.delete(log);
        Files.createSymbolicLink(log, folder);
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(() -> StoreContents.read(file))
                .withMessageContaining(log + " is a folder");
        Files.delete(log);
        Files.createSymbolicLink(log, folder.resolve("missing/log"));
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(() -> StoreContents.read(file))
                .withMessageContaining(log + " is a link");
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(() -> StoreDatabase.open(folder.resolve("none/my.db")))
                .withMessageContaining("there is no folder " + folder.resolve("none"));
    }

    private void refused(String message) {
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> StoreContents.read(file).requireWhole())
                .withMessageContaining(message);
    }

    /** Returns the state that a whole store restores, and its reports. */
    private List<String> read() throws IOException {
        return describe(records());
    }

    private List<String> contents() throws IOException {
        return contents(records());
    }

    private List<JournalRecord> records() throws IOException {
        StoreContents contents = StoreContents.read(file);
        contents.requireWhole();
        problems.clear();
        problems.addAll(contents.problems());
        return contents.records();
    }

    private static SqliteStore open(Path file) throws IOException {
        return new SqliteStore(StoreContents.read(file), Durability.NORMAL);
    }

    private static JournalRecord.Image image(long frame) {
        return new JournalRecord.Image(frame, new byte[100]);
    }

    private void fill() throws IOException {
        fill(file, SEED);
    }

    /** Writes images of the frames 10, 13, 16, 19 and 22, and the frames 11 to 24. */
    private static void fill(Path file, long seed) throws IOException {
        Random random = new Random(seed);
        assertThat(StoreContents.read(file).isEmpty()).isTrue();
        try (SqliteStore store = open(file)) {
            for (int frame = 10; frame <= 24; frame++) {
                if (frame > 10) {
                    store.write(new JournalRecord.Frame(frame, bytes(random, 200)));
                }
                if (frame % 3 == 1) {
                    store.place()
                            .write(
                                    List.of(new JournalRecord.Library(SHA, LIBRARY)),
                                    new JournalRecord.Image(frame, bytes(random, 6000)));
                }
            }
        }
    }

    /**
     * Writes what a world writes that was started again. This is an image of the next frame, and
     * two more frames.
     */
    private static void goOn(Path file) throws IOException {
        try (SqliteStore store = open(file)) {
            byte[] other = new byte[100];
            new Random().nextBytes(other);
            store.place().write(List.of(), new JournalRecord.Image(25, other));
            store.write(new JournalRecord.Frame(26, new byte[20]));
            store.write(new JournalRecord.Frame(27, new byte[20]));
        }
    }

    private static byte[] bytes(Random random, int count) {
        byte[] bytes = new byte[count];
        random.nextBytes(bytes);
        return bytes;
    }

    private static List<String> describe(List<JournalRecord> records) {
        return records.stream()
                .map(
                        record ->
                                switch (record) {
                                    case JournalRecord.Library library ->
                                            "library " + library.sha256();
                                    case JournalRecord.Image image -> "image " + image.frame();
                                    case JournalRecord.Frame frame -> "frame " + frame.frame();
                                })
                .toList();
    }

    /**
     * Returns the contents of records. Libraries are omitted, because their SHA-256 is checked when
     * they are loaded.
     */
    private static List<String> contents(List<JournalRecord> records) {
        return records.stream()
                .filter(record -> !(record instanceof JournalRecord.Library))
                .map(
                        record ->
                                switch (record) {
                                    case JournalRecord.Library library -> "";
                                    case JournalRecord.Image image ->
                                            image.frame() + " " + Arrays.hashCode(image.bytes());
                                    case JournalRecord.Frame frame ->
                                            frame.frame() + " " + Arrays.hashCode(frame.json());
                                })
                .toList();
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
