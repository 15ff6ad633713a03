// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.worlds.Product;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.sql.Connection;
import java.sql.DriverManager;
import java.sql.SQLException;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.Comparator;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.TreeMap;
import java.util.stream.Stream;
import java.util.zip.CRC32C;

/**
 * A store of a killed server is damaged in every way in which files can be damaged. The store
 * resumes unchanged, or it names the damaged file and stays unchanged until its repair is
 * requested.
 */
class StoreDamageNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "spring-orbit", "world.yaml");
    private static final long SEED = Long.getLong("reve.test.seed", 20261122);

    /** Number of damages. A long run uses 1000. */
    private static final int DAMAGES = Integer.getInteger("reve.test.damages", 12);

    private static final int FLIPS = Math.max(6, DAMAGES / 10);
    private static final LawPath LAWS = LawPath.ofShipped();
    private static final String NAME = "my.db";

    @TempDir private Path folder;
    private final Map<Long, Long> hashes = new HashMap<>();
    private final Map<String, Integer> counts = new TreeMap<>();
    private WorldDescription description;

    /**
     * A damage of a store, with the contents of the damaged files by name. The content null removes
     * a file.
     */
    private record Damage(String what, List<String> files, Map<String, byte[]> content) {}

    /** The state in which a store resumed. */
    private record Resumed(long frame, long hash, List<String> problems) {}

    @Test
    void noDamageLosesAWorldInSilenceOrChangesAFile() throws Exception {
        description = WorldFile.load(WORLD);
        Map<String, byte[]> older = killedAfter(50, "one", Map.of());
        older = killedAfter(90, "one", older);
        Map<String, byte[]> whole = killedAfter(135, "one", older);
        Map<String, byte[]> other = killedAfter(135, "two", Map.of());
        killedAfter(135, "one", Map.of()); // the hashes of this run are the reference
        List<Damage> damages = damages(whole, older, other);
        assertThat(damages).hasSizeGreaterThan(100);
        Collections.shuffle(damages, new Random(SEED));
        for (Damage damage : damages.subList(0, Math.min(DAMAGES, damages.size()))) {
            suffer(whole, damage);
        }
        System.out.println("of " + damages.size() + " damages " + counts);
    }

    @Test
    void framesThatAPowerFailureHasLostAreReportedWithTheirNumber() throws Exception {
        description = WorldFile.load(WORLD);
        write(folder, killedAfter(30, "one", Map.of()));
        Path newest;
        try (Stream<Path> all = Files.list(folder)) {
            newest =
                    all.filter(file -> file.getFileName().toString().contains("-frames-"))
                            .max(Comparator.comparing(Path::toString))
                            .orElseThrow();
        }
        byte[] frames = Files.readAllBytes(newest);
        Files.write(newest, Arrays.copyOf(frames, frames.length - 3));
        Path manifest = folder.resolve(NAME + "-manifest");
        byte[] claim = Files.readAllBytes(manifest);
        claim["REVE store manifest 1\n".length() + 16] ^= 1; // the identity of the boot
        var sum = new CRC32C();
        sum.update(claim, 0, claim.length - Integer.BYTES);
        ByteBuffer.wrap(claim).putInt(claim.length - Integer.BYTES, (int) sum.getValue());
        Files.write(manifest, claim);

        Resumed resumed = open(folder);
        assertThat(resumed.hash()).isEqualTo(hashes.get(resumed.frame()));
        assertThat(resumed.problems())
                .singleElement()
                .asString()
                .contains("the machine was started again since")
                .endsWith(
                        "the world resumes at frame "
                                + resumed.frame()
                                + ", and the frame after it is lost");
    }

    @Test
    void aDamagedLawIsTakenFromTheDiskAndWrittenAgain() throws Exception {
        description = WorldFile.load(WORLD);
        Map<String, byte[]> whole = killedAfter(30, "one", Map.of());
        write(folder, whole);
        update("UPDATE library SET bytes = zeroblob(length(bytes))");
        Resumed resumed = open(folder);
        assertThat(resumed.hash()).isEqualTo(hashes.get(30L));
        assertThat(resumed.problems())
                .hasSize(2)
                .allSatisfy(
                        problem ->
                                assertThat(problem)
                                        .contains(
                                                NAME,
                                                "the law library with the SHA-256",
                                                "the same bytes are in"));
        write(folder, killedAfter(40, "one", files(folder)));
        assertThat(open(folder).problems()).isEmpty();
    }

    @Test
    void aDamagedLawThatIsNowhereElseIsRefusedByName() throws Exception {
        description = WorldFile.load(WORLD);
        byte[] shipped =
                Files.readAllBytes(Product.nativeFolder().resolve("laws/libvesper_law_drag.so"));
        byte[] bytes = Arrays.copyOf(shipped, shipped.length + 8); // works the same
        Path own =
                Files.write(
                        Files.createDirectory(folder.resolve("laws"))
                                .resolve("libvesper_law_drag.so"),
                        bytes);
        LawPath laws =
                new LawPath(LAWS.shipped(), Optional.of(own.getParent()), Optional.empty(), false);
        Path store = folder.resolve(NAME);
        StoredWorld world =
                StoredWorld.open(
                        new StoreAddress.InFile(store),
                        SqliteStore.Durability.NORMAL,
                        description,
                        Path.of("."),
                        Pacing.FAST,
                        laws,
                        problem -> {});
        try (Simulation simulation = world.simulation();
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(20, true),
                                world.store(),
                                problem -> {})) {
            simulation.loop().run(0);
            try (var prepared = simulation.engine().prepare(own)) {
                simulation.physics().laws().load(0, prepared, Map.of());
            }
            simulation.loop().run(30);
        }
        update("UPDATE library SET bytes = zeroblob(length(bytes))");
        Map<String, byte[]> damaged = files(folder);
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> open(folder))
                .withMessageContaining("the law library drag (SHA-256 ")
                .withMessageContaining("--laws");
        same(folder, damaged, "refused");
        assertThat(StoreCheck.of(new StoreAddress.InFile(store), laws).isWhole()).isTrue();
    }

    /** Dangling links and folders are no files, but are moved away like files. */
    @Test
    void whatStandsInPlaceOfAFileIsNamedAndSetAside() throws Exception {
        description = WorldFile.load(WORLD);
        Map<String, byte[]> whole = killedAfter(50, "one", Map.of());
        for (String name :
                List.of(
                        NAME + "-manifest",
                        whole.keySet().stream()
                                .filter(each -> each.contains("-frames-"))
                                .max(String::compareTo)
                                .orElseThrow())) {
            for (boolean isFolder : List.of(true, false)) {
                Path place = Files.createTempDirectory(folder, "instead");
                write(place, whole);
                Path instead = place.resolve(name);
                Files.delete(instead);
                if (isFolder) {
                    Files.createFile(Files.createDirectory(instead).resolve("content"));
                } else {
                    Files.createSymbolicLink(instead, place.resolve("nowhere"));
                }
                assertThat(
                                StoreCheck.of(new StoreAddress.InFile(place.resolve(NAME)), LAWS)
                                        .problems())
                        .anyMatch(
                                problem ->
                                        problem.contains(
                                                instead
                                                        + (isFolder
                                                                ? " is a folder"
                                                                : " is a link to a file that is not"
                                                                        + " there")));
                assertThatExceptionOfType(CorruptException.class)
                        .isThrownBy(() -> open(place))
                        .withMessageContaining(instead.toString());
                Path aside = StoreCheck.repair(place.resolve(NAME), LAWS).getValue().orElseThrow();
                assertThat(Files.exists(aside.resolve(name), LinkOption.NOFOLLOW_LINKS)).isTrue();
                assertThat(open(place).problems()).isEmpty();
            }
        }
    }

    @Test
    void aCheckLeavesALinkToNothingAloneAndMakesNoFileOfIt() throws Exception {
        description = WorldFile.load(WORLD);
        write(folder, killedAfter(50, "one", Map.of()));
        Path link = folder.resolve(NAME + "-wal");
        Files.deleteIfExists(link);
        Path nowhere = folder.resolve("nowhere");
        Files.createSymbolicLink(link, nowhere);
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(
                        () -> StoreCheck.of(new StoreAddress.InFile(folder.resolve(NAME)), LAWS))
                .withMessageStartingWith(link + " is a link to a file that is not there");
        assertThat(link).isSymbolicLink();
        assertThat(nowhere).doesNotExist();
    }

    @Test
    void filesThatCannotAllBeMovedStayWhereTheyWere() throws Exception {
        Map<Path, Path> moves = new LinkedHashMap<>();
        for (String name : List.of("a", "b", "c")) {
            moves.put(Files.writeString(folder.resolve(name), name), folder.resolve(name + "2"));
        }
        Path taken = Files.writeString(folder.resolve("c2"), "taken");
        assertThatExceptionOfType(IOException.class)
                .isThrownBy(() -> StoreCheck.moveAll(moves))
                .withMessage(
                        folder.resolve("c")
                                + " could not be moved to "
                                + taken
                                + ": there is a file already (everything was put back)");
        assertThat(files(folder).keySet()).containsExactly("a", "b", "c", "c2");
        assertThat(taken).hasContent("taken");
    }

    private void update(String sql) throws SQLException {
        try (Connection connection =
                        DriverManager.getConnection("jdbc:sqlite:" + folder.resolve(NAME));
                var statement = connection.createStatement()) {
            statement.executeUpdate(sql);
        }
    }

    private void suffer(Map<String, byte[]> whole, Damage damage) throws Exception {
        Path place = Files.createTempDirectory(folder, "damaged");
        Map<String, byte[]> damaged = new TreeMap<>(whole);
        damage.content()
                .forEach(
                        (name, bytes) -> {
                            damaged.remove(name);
                            if (bytes != null) {
                                damaged.put(name, bytes);
                            }
                        });
        write(place, damaged);
        String which = damage.what() + " (seed " + SEED + ")";
        try {
            Resumed resumed = open(place);
            count(resumed.problems().isEmpty() ? "without a message" : "with a message");
            assertThat(resumed.frame()).as(which + resumed.problems()).isEqualTo(135);
            assertThat(resumed.hash()).as(which).isEqualTo(hashes.get(135L));
            return;
        } catch (CorruptException | IOException refused) {
            count("refused");
            assertThat(damage.files())
                    .as(which + ": " + refused.getMessage())
                    .anyMatch(refused.getMessage()::contains);
            same(place, damaged, which);
        }
        repair(place, damaged, damage, which);
        remove(place);
    }

    private void repair(Path place, Map<String, byte[]> damaged, Damage damage, String which)
            throws Exception {
        StoreCheck was;
        Path aside;
        try {
            was = StoreCheck.of(new StoreAddress.InFile(place.resolve(NAME)), LAWS);
            assertThat(StoreLaws.of(new StoreAddress.InFile(place.resolve(NAME)), LAWS).frame())
                    .as(which)
                    .isEqualTo(was.frame());
            same(place, damaged, which + ", checked");
            aside = StoreCheck.repair(place.resolve(NAME), LAWS).getValue().orElseThrow();
        } catch (CorruptException | IOException lost) {
            count("nothing can be recovered");
            assertThat(damage.files())
                    .as(which + ": " + lost.getMessage())
                    .anyMatch(file -> file.equals(NAME) || file.equals(NAME + "-wal"));
            same(place, damaged, which + ", not repaired");
            return;
        }
        count("repaired");
        same(aside, damaged, which + ", set aside");
        Resumed resumed = open(place);
        assertThat(resumed.frame()).as(which).isEqualTo(was.frame());
        assertThat(resumed.hash())
                .as(which)
                .isEqualTo(was.stateHash())
                .isEqualTo(hashes.get(resumed.frame()));
    }

    private void count(String outcome) {
        counts.merge(outcome, 1, Integer::sum);
    }

    private Resumed open(Path place) throws IOException {
        List<String> problems = new ArrayList<>();
        StoredWorld world =
                StoredWorld.open(
                        new StoreAddress.InFile(place.resolve(NAME)),
                        SqliteStore.Durability.NORMAL,
                        description,
                        Path.of("."),
                        Pacing.FAST,
                        LAWS,
                        problems::add);
        try (Simulation simulation = world.simulation();
                JournalSink _ = world.store()) {
            return new Resumed(simulation.loop().frame(), world.stateHash(), problems);
        }
    }

    private static List<Damage> damages(
            Map<String, byte[]> whole, Map<String, byte[]> older, Map<String, byte[]> other) {
        Random random = new Random(SEED);
        List<Damage> all = new ArrayList<>();
        whole.forEach(
                (name, bytes) -> {
                    all.add(damage("without ", name, null));
                    all.add(damage("empty ", name, new byte[0]));
                    all.add(damage("garbage in ", name, "Dear diary".repeat(30).getBytes()));
                    for (int length :
                            bytes.length < 2
                                    ? new int[0]
                                    : new int[] {
                                        1,
                                        bytes.length / 2,
                                        bytes.length - 1,
                                        random.nextInt(bytes.length),
                                        random.nextInt(bytes.length)
                                    }) {
                        all.add(
                                damage(
                                        "cut at byte " + length + ": ",
                                        name,
                                        Arrays.copyOf(bytes, length)));
                    }
                    for (int i = 0; i < FLIPS && bytes.length > 0; i++) {
                        int bit = random.nextInt(8 * bytes.length);
                        byte[] flipped = bytes.clone();
                        flipped[bit / 8] ^= (byte) (1 << bit % 8);
                        all.add(damage("bit " + bit + " of ", name, flipped));
                    }
                    for (int i = 0; i < 3 && bytes.length > 0; i++) {
                        byte[] zeros = bytes.clone();
                        int from = random.nextInt(bytes.length);
                        Arrays.fill(zeros, from, Math.min(bytes.length, from + 4096), (byte) 0);
                        all.add(damage("zeros from byte " + from + " on in ", name, zeros));
                    }
                    if (other.containsKey(name)) {
                        all.add(damage("another store's ", name, other.get(name)));
                    }
                    if (older.containsKey(name)) {
                        all.add(damage("an older ", name, older.get(name)));
                    }
                });
        List<String> frames =
                whole.keySet().stream().filter(name -> name.contains("-frames-")).toList();
        all.add(
                without(
                        "nothing but the database",
                        whole.keySet().stream().filter(name -> !name.equals(NAME)).toList()));
        all.add(without("no frames", frames));
        all.add(without("no newest frames", frames.subList(frames.size() - 2, frames.size())));
        all.add(
                without(
                        "no newest frames and no manifest",
                        List.of(frames.getLast(), NAME + "-manifest")));
        if (older.containsKey(NAME + "-manifest")) {
            Map<String, byte[]> cut = new HashMap<>();
            cut.put(NAME + "-manifest", older.get(NAME + "-manifest"));
            cut.put(frames.getLast(), null);
            all.add(
                    new Damage(
                            "an older manifest, no newest frames", List.copyOf(cut.keySet()), cut));
            byte[] newest = whole.get(frames.getLast());
            all.add(
                    new Damage(
                            "an older manifest, newest frames cut",
                            List.copyOf(cut.keySet()),
                            Map.of(
                                    NAME + "-manifest",
                                    older.get(NAME + "-manifest"),
                                    frames.getLast(),
                                    Arrays.copyOf(newest, newest.length / 2))));
        }
        all.add(without("no database and no log", List.of(NAME, NAME + "-wal")));
        all.add(without("no database and no manifest", List.of(NAME, NAME + "-manifest")));
        for (String frame : frames) {
            all.add(
                    new Damage(
                            "another file as " + frame,
                            List.of(frame),
                            Map.of(
                                    frame,
                                    whole.get(
                                            frames.get(
                                                    (frames.indexOf(frame) + 1)
                                                            % frames.size())))));
        }
        return all;
    }

    private static Damage damage(String what, String name, byte[] content) {
        return new Damage(what + name, List.of(name), Collections.singletonMap(name, content));
    }

    private static Damage without(String what, List<String> names) {
        Map<String, byte[]> gone = new HashMap<>();
        names.forEach(name -> gone.put(name, null));
        return new Damage(what, names, gone);
    }

    /**
     * Continues a store up to a frame. Ends without a last image, as a killed process does.
     *
     * @param run the push of the bodies
     */
    private Map<String, byte[]> killedAfter(long frame, String run, Map<String, byte[]> before)
            throws IOException {
        Path place = Files.createTempDirectory(folder, "run");
        write(place, before);
        List<String> problems = Collections.synchronizedList(new ArrayList<>());
        StoredWorld world =
                StoredWorld.open(
                        new StoreAddress.InFile(place.resolve(NAME)),
                        SqliteStore.Durability.NORMAL,
                        description,
                        Path.of("."),
                        Pacing.FAST,
                        LAWS,
                        problems::add);
        var sink = new Killed(world.store(), place, frame);
        try (Simulation simulation = world.simulation();
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(20, true),
                                sink,
                                problems::add)) {
            simulation.loop().run(0);
            while (simulation.loop().frame() < frame) {
                Random random = new Random((run + simulation.loop().frame()).hashCode());
                simulation
                        .world()
                        .find("blue")
                        .orElseThrow()
                        .physics()
                        .set("velocity", random.nextGaussian(), 0, 0);
                var laws = simulation.physics().laws();
                if (simulation.loop().frame() == 125) {
                    laws.load(125, "drag", Map.of());
                }
                simulation.loop().step();
                hashes.put(simulation.loop().frame(), simulation.physics().stateHash());
            }
        }
        assertThat(problems)
                .allMatch(
                        problem ->
                                problem.contains("killed")
                                        || problem.contains("the same bytes are in"));
        return sink.left;
    }

    /**
     * A sink that leaves the files of a killed process. They have everything except the image at
     * the end.
     */
    private static final class Killed implements JournalSink {
        private final JournalSink store;
        private final Path place;
        private final long last;
        private long newest;
        private Map<String, byte[]> left = Map.of();

        Killed(JournalSink store, Path place, long last) {
            this.store = store;
            this.place = place;
            this.last = last;
        }

        @Override
        public void write(JournalRecord record) throws IOException {
            store.write(record);
            if (record instanceof JournalRecord.Frame frame) {
                newest = frame.frame();
            }
        }

        @Override
        public Place place() throws IOException {
            if (newest == last) {
                throw new IOException("killed");
            }
            return store.place();
        }

        @Override
        public void sync() throws IOException {
            store.sync();
        }

        @Override
        public void close() throws IOException {
            left = files(place);
            store.close();
        }
    }

    private static Map<String, byte[]> files(Path place) throws IOException {
        Map<String, byte[]> files = new TreeMap<>();
        try (Stream<Path> all = Files.list(place)) {
            for (Path each : all.filter(Files::isRegularFile).toList()) {
                files.put(each.getFileName().toString(), Files.readAllBytes(each));
            }
        }
        return files;
    }

    private static void write(Path place, Map<String, byte[]> files) throws IOException {
        for (Map.Entry<String, byte[]> each : files.entrySet()) {
            Files.write(place.resolve(each.getKey()), each.getValue());
        }
    }

    private static void same(Path place, Map<String, byte[]> expected, String which)
            throws IOException {
        Map<String, byte[]> found = files(place);
        assertThat(found.keySet()).as(which).isEqualTo(expected.keySet());
        expected.forEach(
                (name, bytes) ->
                        assertThat(Arrays.equals(found.get(name), bytes))
                                .as(which + ": " + name)
                                .isTrue());
    }

    private static void remove(Path place) throws IOException {
        try (Stream<Path> all = Files.walk(place)) {
            for (Path each : all.toList().reversed()) {
                Files.delete(each);
            }
        }
    }
}
