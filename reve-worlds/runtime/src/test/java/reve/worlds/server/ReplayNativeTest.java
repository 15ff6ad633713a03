// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.InstanceOfAssertFactories.STRING;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.core.world.Force;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Shape;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.Recording;
import reve.worlds.journal.RecordingPlan;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.SimulationImage;

import java.io.IOError;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.Random;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.function.UnaryOperator;
import java.util.regex.Matcher;

/** A run with every kind of intervention, recorded and repeated. */
@Tag("slow")
class ReplayNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "icosahedron", "world.yaml");
    private static final long SEED = 20261121;
    private static final int FRAMES = 120;

    @TempDir private Path folder;
    private WorldDescription description;
    private Path log;

    @BeforeEach
    void read() throws Exception {
        description = WorldFile.load(WORLD);
        log = folder.resolve("run.log");
    }

    @Test
    void aRunIsMadeAgainToTheBit() throws IOException {
        long hash = record(FRAMES, this::interfere);
        try (Replay replay = replay(log)) {
            assertThat(replay.divergence()).isEmpty();
            assertThat(replay.frames()).isEqualTo(FRAMES);
            try (Simulation again = replay.release()) {
                assertThat(again.physics().stateHash()).isEqualTo(hash);
                assertThat(again.physics().laws().loaded().stream().map(law -> law.name()))
                        .doesNotContain("drag");
            }
        }
    }

    /** surface_contact remembers a contact that lasts, as the spring of its static friction. */
    @Test
    void lawsKeepWhatTheyRememberWhenParametersChange() throws IOException {
        long undisturbed = record(FRAMES, (simulation, frame) -> {});
        Files.delete(log);
        assertThat(record(FRAMES, maximumDepth(2.0)))
                .as("a depth not reached")
                .isEqualTo(undisturbed);
        Files.delete(log);
        long loose = record(FRAMES, maximumDepth(1e-6));
        assertThat(loose).isNotEqualTo(undisturbed);
        try (Replay replay = replay(log);
                Simulation again = replay.release()) {
            assertThat(replay.divergence()).isEmpty();
            assertThat(again.physics().stateHash()).isEqualTo(loose);
        }
    }

    private static Interference maximumDepth(double metres) {
        return (simulation, frame) -> {
            if (frame == FRAMES / 2) {
                simulation
                        .physics()
                        .laws()
                        .setParameters(frame, "surface_contact", Map.of("maximumDepth", metres));
            }
        };
    }

    @Test
    void goingBackInTheRecordedRunIsFollowed() throws IOException {
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ = journal(simulation)) {
            simulation.loop().run(20);
            SimulationImage image = simulation.keep();
            simulation.loop().run(20);
            simulation.rewind(image);
            simulation.world().find("c3").orElseThrow().physics().set("velocity", 0, 5, 0);
            simulation.loop().run(30);
            hash = simulation.physics().stateHash();
        }
        try (Replay replay = replay(log);
                Simulation again = replay.release()) {
            assertThat(replay.divergence()).isEmpty();
            assertThat(again.loop().frame()).isEqualTo(71);
            assertThat(again.physics().stateHash()).isEqualTo(hash);
        }
    }

    @Test
    void oneFlippedInputIsCaughtByFrameItemAndProperty() throws IOException {
        record(
                60,
                (simulation, frame) -> {
                    if (frame == 40) {
                        simulation
                                .world()
                                .find("c7")
                                .orElseThrow()
                                .physics()
                                .set("velocity", 0, 2.5, 0);
                    }
                });
        Path forged = folder.resolve("forged.log");
        forge(forged, "[0.0,2.5,0.0]", "[0.0,2.500000001,0.0]");
        try (Replay replay = replay(forged)) {
            Replay.Divergence found = replay.divergence().orElseThrow();
            assertThat(found.frame()).isEqualTo(41);
            assertThat(found.item()).contains("c7");
            assertThat(found.property()).isEqualTo("velocity");
            assertThat(found.message()).isEqualTo("frame 41: c7: velocity differs");
        }
    }

    @Test
    void anotherResultOfTheLawsIsCaught() throws IOException {
        record(60, (simulation, frame) -> {});
        Path forged = folder.resolve("forged.log");
        forge(forged, "\"frame\":30,\"digest\":\"AA", "\"frame\":30,\"digest\":\"AB");
        try (Replay replay = replay(forged)) {
            assertThat(replay.divergence().orElseThrow().frame()).isEqualTo(30);
        }
    }

    /** The record has a valid checksum, because another program can write such a record. */
    @Test
    void aFrameThatCannotBeReadIsNamedWithWhatWasExpected() throws IOException {
        record(
                8,
                (simulation, frame) -> {
                    if (frame == 5) {
                        simulation
                                .world()
                                .find("c7")
                                .orElseThrow()
                                .physics()
                                .set("velocity", 0, 2.5, 0);
                    }
                });
        Map<String, String> digests = new LinkedHashMap<>();
        digests.put("null", "found null, expected a text");
        digests.put("1180591620717411303424", "found 1180591620717411303424, expected a text");
        digests.put("-1", "found -1, expected a text");
        digests.put("[null,null]", "found a list, expected a text");
        digests.put("[[[[]]]]", "found a list, expected a text");
        digests.put("{\"a\":null}", "found an object, expected a text");
        digests.put("\"?\"", "found no Base64, expected a digest");
        digests.put("\"AAAA\"", "found 3 bytes, expected a digest in parts of 18 bytes");
        for (String field : List.of("digest", "before")) {
            digests.forEach(
                    (value, found) ->
                            refused(
                                    json ->
                                            json.replaceFirst(
                                                    "\"" + field + "\":\"[^\"]*\"",
                                                    "\""
                                                            + field
                                                            + "\":"
                                                            + Matcher.quoteReplacement(value)),
                                    "the field " + field + ": " + found));
        }
        refused(
                json -> json.replace("\"frame\":6", "\"frame\":1180591620717411303424"),
                "the field frame: found 1180591620717411303424, expected an integer of 64 bits");
        refused(
                json -> json.replace("[0.0,2.5,0.0]", "[null,2.5,0.0]"),
                "a number: found null, expected a number");
        refused(
                json ->
                        json.replace(
                                "\"changes\"",
                                "\"laws\":[{\"law\":\"unloaded\","
                                        + "\"place\":7000}],\"changes\""),
                "it does not fit this world");
        for (String field : List.of("changes", "laws", "late", "events")) {
            refused(
                    json ->
                            json.replace("\"changes\"", "\"old\"")
                                    .replace("\"digest\"", "\"" + field + "\":\"x\",\"digest\""),
                    "the field " + field + ": found \"x\", expected a list");
        }
        refused(
                json -> "[".repeat(200_000),
                "JSON is nested too deep, or a text or number of it " + "is too long");
        refused(json -> "null", "the field frame is missing");
        refused(json -> "", "the field frame is missing");
    }

    private void refused(UnaryOperator<String> change, String message) {
        Path forged = folder.resolve("forged.log");
        try (RunLog.Reader records = RunLog.open(log);
                JournalSink sink = new Recording(RecordingPlan.of(forged))) {
            while (records.hasNext()) {
                JournalRecord record = records.next();
                if (record instanceof JournalRecord.Frame frame && frame.frame() == 6) {
                    String json = new String(frame.json(), StandardCharsets.UTF_8);
                    String other = change.apply(json);
                    assertThat(other).isNotEqualTo(json);
                    sink.write(new JournalRecord.Frame(6, other.getBytes(StandardCharsets.UTF_8)));
                } else {
                    sink.write(record);
                }
            }
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
        assertThatExceptionOfType(CorruptException.class)
                .isThrownBy(() -> replay(forged))
                .withMessageStartingWith("the record of frame 6: ")
                .withMessageContaining(message)
                .satisfies(
                        refused ->
                                assertThat(refused.getMessage())
                                        .doesNotContain("Node", "java", "Stream")
                                        .hasLineCount(1));
    }

    @Test
    void anInputThatIsMissingIsCaught() throws IOException {
        record(
                60,
                (simulation, frame) -> {
                    if (frame == 30) {
                        simulation
                                .world()
                                .add(ItemDefinition.named("late").physics("mass", 1).build());
                    }
                });
        Path forged = folder.resolve("forged.log");
        forge(forged, "\"changes\":", "\"unknown\":");
        try (Replay replay = replay(forged)) {
            assertThat(replay.divergence().orElseThrow().message())
                    .isEqualTo("frame 31: the items of kind body differ");
        }
    }

    @Test
    void aRecordingThatIsCutEndsBeforeAndADamagedOneIsRefused() throws IOException {
        record(60, (simulation, frame) -> {});
        byte[] whole = Files.readAllBytes(log);
        Random random = new Random(SEED);
        for (int i = 0; i < 40; i++) {
            int length = whole.length - 1 - random.nextInt(2000);
            Files.write(log, Arrays.copyOf(whole, length));
            try (RunLog.Reader records = RunLog.open(log)) {
                records.forEachRemaining(record -> {});
                assertThat(records.wasCut()).as("%d of %d bytes", length, whole.length).isTrue();
            }
            byte[] flipped = whole.clone();
            int bit = random.nextInt(8 * whole.length);
            flipped[bit / 8] ^= (byte) (1 << bit % 8);
            Files.write(log, flipped);
            assertThat(found(bit)).as("bit %d", bit).isTrue();
        }
    }

    /** A flipped length may make a record reach past the end, which looks like a truncation. */
    private boolean found(int bit) throws IOException {
        try (RunLog.Reader records = RunLog.open(log)) {
            records.forEachRemaining(record -> {});
            return records.wasCut();
        } catch (CorruptException damaged) {
            return damaged.getMessage().contains(log.toString());
        }
    }

    /**
     * If a process ends after any record, the later records are lost, and the earlier ones are
     * kept.
     */
    @Test
    void whateverRecordIsTheLastTheWorldIsAsItWasAtItsLastFrame() throws IOException {
        List<Long> hashes = new ArrayList<>();
        record(
                40,
                (simulation, frame) -> {
                    hashes.add(simulation.physics().stateHash());
                    interfere(simulation, frame);
                });
        List<JournalRecord> records = new ArrayList<>();
        try (RunLog.Reader reader = RunLog.open(log)) {
            reader.forEachRemaining(records::add);
        }
        long made = 0;
        for (int kept = 1; kept <= records.size(); kept++) {
            if (records.get(kept - 1) instanceof JournalRecord.Library) {
                continue;
            }
            try (Replay replay = new Replay(Optional.empty(), Pacing.FAST)) {
                records.subList(0, kept)
                        .forEach(record -> assertThat(replay.take(record)).isTrue());
                try (Simulation resumed = replay.release()) {
                    made = resumed.loop().frame();
                    if (made < hashes.size()) {
                        assertThat(resumed.physics().stateHash()).isEqualTo(hashes.get((int) made));
                    }
                }
            }
        }
        assertThat(made).isEqualTo(40);
    }

    @Test
    void aSinkThatFailsCostsTheJournalUpToTheNextImageAndNothingElse() throws Exception {
        List<List<JournalRecord>> kept = new ArrayList<>();
        List<String> problems = new ArrayList<>();
        try (Simulation simulation = new Simulation(description, Pacing.FAST)) {
            try (Journal _ =
                    simulation.journal(
                            WORLD.getParent(),
                            Map.of(),
                            new Journal.Plan(20, true),
                            failingAtFirstFrame(kept),
                            problems::add)) {
                simulation.loop().run(100);
            }
            assertThat(simulation.loop().frame()).isEqualTo(100);
            assertThat(problems).isNotEmpty().first().asString().contains("disk full");
        }
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST)) {
            kept.forEach(
                    records -> records.forEach(record -> assertThat(replay.take(record)).isTrue()));
            assertThat(replay.release().loop().frame()).isEqualTo(100);
        }
    }

    /** If an image of an earlier frame is still being written, it does not make a store whole. */
    @Test
    void aStoreIsWholeAgainFromTheNextImageOn() throws Exception {
        Queue<String> problems = new ConcurrentLinkedQueue<>();
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(20, true),
                                failingDuringSecondImage(),
                                problems::add)) {
            simulation.loop().run(100);
        }
        assertThat(problems)
                .satisfiesExactly(
                        refused ->
                                assertThat(refused)
                                        .contains("disk full", "loses the frames from 25 on"),
                        whole ->
                                assertThat(whole)
                                        .isEqualTo(
                                                "the store is complete again from the image of"
                                                        + " frame 40 on"));
    }

    /** Returns a sink that refuses frame 25 while the image of frame 20 is being written. */
    private static JournalSink failingDuringSecondImage() {
        return new ListSink(new ArrayList<>()) {
            private final CountDownLatch refused = new CountDownLatch(1);

            @Override
            public void write(JournalRecord record) throws IOException {
                if (record instanceof JournalRecord.Frame frame && frame.frame() == 25) {
                    refused.countDown();
                    throw new IOException("disk full");
                }
                super.write(record);
            }

            @Override
            public Place place() {
                Place place = super.place();
                return (libraries, image) -> {
                    if (image.frame() == 20) {
                        await(refused);
                    }
                    place.write(libraries, image);
                };
            }
        };
    }

    private static void await(CountDownLatch latch) throws IOException {
        try {
            assertThat(latch.await(60, TimeUnit.SECONDS)).isTrue();
        } catch (InterruptedException e) {
            throw new IOException(e);
        }
    }

    /**
     * Such an error can occur if there is no memory. In each place it costs the same frames as a
     * disk that refuses a write.
     */
    @ParameterizedTest
    @ValueSource(strings = {"frame", "place", "image"})
    void anErrorWhileItWritesCostsTheJournalUpToTheNextImage(String where) throws Exception {
        List<List<JournalRecord>> kept = new ArrayList<>();
        Queue<String> problems = new ConcurrentLinkedQueue<>();
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(20, true),
                                breakingAtSecond(where, kept),
                                problems::add)) {
            simulation.loop().run(100);
        }
        assertThat(problems).isNotEmpty().first().asString().contains("java.lang.Error: broken");
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST)) {
            kept.forEach(
                    records -> records.forEach(record -> assertThat(replay.take(record)).isTrue()));
            assertThat(replay.release().loop().frame()).isEqualTo(100);
        }
    }

    @Test
    void lostFilesAreToldAndAnImageThatBeginsAnewIsWrittenAtOnce() throws Exception {
        List<List<JournalRecord>> kept = new ArrayList<>();
        Queue<String> problems = new ConcurrentLinkedQueue<>();
        var looked = new CountDownLatch(1);
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(20, true),
                                losingItsFile(kept),
                                problem -> {
                                    problems.add(problem);
                                    looked.countDown();
                                })) {
            looked.await(); // the world waits meanwhile
            assertThat(problems).containsExactly("my.db was removed");
            problems.clear();
            simulation.loop().run(50);
        }
        assertThat(problems)
                .containsExactly(
                        "my.db was created again; it continues with the image of frame 40");
        assertThat(
                        kept.stream()
                                .flatMap(List::stream)
                                .filter(JournalRecord.Image.class::isInstance))
                .extracting(record -> ((JournalRecord.Image) record).frame())
                .containsExactly(0L, 20L, 40L, 50L);
    }

    /**
     * Returns a sink that reports the loss of a file once, and starts again with its third image.
     */
    private static JournalSink losingItsFile(List<List<JournalRecord>> kept) {
        return new ListSink(kept) {
            private int images;
            private int looks;

            @Override
            public List<String> troubles() {
                return looks++ == 0 ? List.of("my.db was removed") : List.of();
            }

            @Override
            public Place place() {
                Place place = super.place();
                return (libraries, image) -> {
                    if (++images == 3) {
                        throw new BegunAnewException("my.db was created again");
                    }
                    place.write(libraries, image);
                };
            }
        };
    }

    @ParameterizedTest
    @ValueSource(booleans = {true, false})
    void aWorldWhoseJournalHasEndedStopsAndSaysWhy(boolean waits) {
        Error cannotTell = new Error("nobody can be told");
        try (Simulation simulation = new Simulation(description, Pacing.FAST)) {
            Journal journal =
                    simulation.journal(
                            WORLD.getParent(),
                            Map.of(),
                            new Journal.Plan(20, waits),
                            breakingAtSecond("frame", new ArrayList<>()),
                            problem -> {
                                throw cannotTell;
                            });

            assertThatThrownBy(() -> runSlowly(simulation, 10_000))
                    .isInstanceOf(IOError.class)
                    .hasMessageContaining("the journal has ended after frame")
                    .hasMessageContaining("nobody can be told");
            // Without waiting, the world makes a frame in each 10 ms until the other thread, which
            // a busy machine may delay, has ended the journal.
            assertThat(simulation.loop().frame()).isLessThan(waits ? 5 : 1000);
            assertThatThrownBy(journal::close).isSameAs(cannotTell);
        }
    }

    /** Makes at most 100 frames per second, so that another thread can follow. */
    private static void runSlowly(Simulation simulation, int frames) {
        for (int i = 0; i < frames; i++) {
            simulation.loop().step();
            LockSupport.parkNanos(10_000_000);
        }
    }

    /** Returns the problems, except that a busy machine writes slowly. */
    private static List<String> withoutSlowness(List<String> problems) {
        return problems.stream()
                .filter(problem -> !problem.startsWith("the disk is slow: "))
                .toList();
    }

    /** Returns a sink that throws an Error for the second frame, place or image. */
    private static JournalSink breakingAtSecond(String where, List<List<JournalRecord>> kept) {
        return new ListSink(kept) {
            private final Map<String, Integer> asked = new ConcurrentHashMap<>();

            private void ask(String what) {
                if (asked.merge(what, 1, Integer::sum) == 2 && what.equals(where)) {
                    throw new Error("broken");
                }
            }

            @Override
            public void write(JournalRecord record) throws IOException {
                if (record instanceof JournalRecord.Frame) {
                    ask("frame");
                }
                super.write(record);
            }

            @Override
            public Place place() {
                ask("place");
                Place place = super.place();
                return (libraries, image) -> {
                    ask("image");
                    place.write(libraries, image);
                };
            }
        };
    }

    /** The world continues, and an image replaces the missing frames. */
    @Test
    void aDiskThatHangsIsToldAndCostsNoMoreThanTheFramesThatFindNoRoom() throws Exception {
        List<List<JournalRecord>> kept = new ArrayList<>();
        List<String> problems = new ArrayList<>();
        CountDownLatch mended = new CountDownLatch(1);
        long hash;
        try (Simulation simulation = new Simulation(description, Pacing.FAST)) {
            try (Journal _ =
                    simulation.journal(
                            WORLD.getParent(),
                            Map.of(),
                            new Journal.Plan(100_000, false),
                            hangingAtFirstFrame(kept, mended),
                            problems::add)) {
                simulation.loop().run(2100);
                assertThat(withoutSlowness(problems))
                        .satisfiesExactly(
                                one -> assertThat(one).startsWith("the disk is too slow: frame 1 "),
                                two ->
                                        assertThat(two)
                                                .startsWith(
                                                        "the disk is too slow: frames from 2049"
                                                                + " on"));
                mended.countDown();
                simulation.loop().run(100);
                hash = simulation.physics().stateHash();
            }
        }
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST)) {
            kept.forEach(
                    records -> records.forEach(record -> assertThat(replay.take(record)).isTrue()));
            assertThat(replay.frames()).isBetween(2048L, 2200L);
            try (Simulation again = replay.release()) {
                assertThat(again.loop().frame()).isEqualTo(2200);
                assertThat(again.physics().stateHash()).isEqualTo(hash);
            }
        }
    }

    /** Later images, such as the second one, do not get the longer time of the first image. */
    @Test
    void aFileThatCannotBeOpenedForALaterImageCostsOneSecond() throws Exception {
        List<String> problems = new CopyOnWriteArrayList<>();
        CountDownLatch mended = new CountDownLatch(1);
        JournalSink sink =
                new ListSink(new ArrayList<>()) {
                    private int places;

                    @Override
                    public Place place() {
                        if (++places == 2) {
                            awaitUninterruptibly(mended);
                        }
                        return super.place();
                    }
                };
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(10, false),
                                sink,
                                problems::add)) {
            long start = System.nanoTime();
            simulation.loop().run(100);
            long nanos = System.nanoTime() - start;
            mended.countDown();
            assertThat(withoutSlowness(problems))
                    .singleElement(STRING)
                    .startsWith("the disk is too slow: frame 10 ");
            assertThat(nanos)
                    .as("one wait; without it, each of 9 images waits for 5 s")
                    .isBetween(1_000_000_000L, 30_000_000_000L);
        }
    }

    @Test
    void aDiskThatSlowsTheWorldIsReported() throws Exception {
        List<String> problems = new ArrayList<>();
        JournalSink sink =
                new ListSink(new ArrayList<>()) {
                    @Override
                    public void write(JournalRecord record) throws IOException {
                        LockSupport.parkNanos(20_000_000);
                        super.write(record);
                    }
                };
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(100_000, false),
                                sink,
                                problems::add)) {
            while (problems.isEmpty() && simulation.loop().frame() < 1000) {
                simulation.loop().run(10);
            }
            assertThat(problems)
                    .singleElement(STRING)
                    .matches("the disk is slow: the world waited for it \\d+\\.\\d of the last .*");
            assertThat(simulation.loop().frame()).isLessThan(400);
        }
    }

    private static void awaitUninterruptibly(CountDownLatch latch) {
        try {
            latch.await();
        } catch (InterruptedException e) {
            throw new IllegalStateException(e);
        }
    }

    private static JournalSink hangingAtFirstFrame(
            List<List<JournalRecord>> kept, CountDownLatch mended) {
        return new ListSink(kept) {
            @Override
            public void write(JournalRecord record) throws IOException {
                try {
                    mended.await();
                } catch (InterruptedException e) {
                    throw new IOException(e);
                }
                super.write(record);
            }
        };
    }

    private static JournalSink failingAtFirstFrame(List<List<JournalRecord>> kept) {
        return new ListSink(kept) {
            private boolean failed;

            @Override
            public void write(JournalRecord record) throws IOException {
                if (!failed && record instanceof JournalRecord.Frame) {
                    failed = true;
                    throw new IOException("disk full");
                }
                super.write(record);
            }
        };
    }

    /**
     * A sink that keeps records in memory. Each image starts a new list, which has the image and
     * the records after it.
     */
    private static class ListSink implements JournalSink {
        private final List<List<JournalRecord>> kept;

        ListSink(List<List<JournalRecord>> kept) {
            this.kept = kept;
        }

        @Override
        public void write(JournalRecord record) throws IOException {
            kept.getLast().add(record);
        }

        @Override
        public Place place() {
            List<JournalRecord> own = new ArrayList<>();
            kept.add(own);
            kept.add(new ArrayList<>());
            return (libraries, image) -> {
                own.addAll(libraries);
                own.add(image);
            };
        }

        @Override
        public void sync() {
            // nothing outlives this process
        }

        @Override
        public void close() {
            // nothing is open
        }
    }

    private interface Interference {
        void before(Simulation simulation, int frame);
    }

    private long record(int frames, Interference interference) throws IOException {
        try (Simulation simulation = new Simulation(description, Pacing.FAST);
                Journal _ = journal(simulation)) {
            simulation.loop().run(0);
            for (int frame = 0; frame < frames; frame++) {
                interference.before(simulation, frame);
                simulation.loop().step();
            }
            return simulation.physics().stateHash();
        }
    }

    private Journal journal(Simulation simulation) throws IOException {
        return simulation.journal(
                WORLD.getParent(),
                Map.of(),
                new Journal.Plan(0, true),
                new Recording(RecordingPlan.of(log)),
                problem -> {
                    throw new AssertionError(problem);
                });
    }

    private static Replay replay(Path file) throws IOException {
        Replay replay = new Replay(Optional.empty(), Pacing.FAST);
        try (RunLog.Reader records = RunLog.open(file)) {
            while (records.hasNext() && replay.take(records.next())) {
                // the list stays open for further records
            }
        }
        return replay;
    }

    /**
     * Sets, pushes, adds, removes, attaches and renames, and loads and unloads a law, at random.
     */
    private void interfere(Simulation simulation, int frame) {
        Random random = new Random(SEED + frame);
        var world = simulation.world();
        Item corner = world.find("c" + random.nextInt(12)).orElseThrow();
        switch (frame % 10) {
            case 0 -> corner.physics().set("velocity", random.nextGaussian(), 1, 0);
            case 1 ->
                    world.add(
                            ItemDefinition.named("ball " + frame)
                                    .shape(Shape.sphere(0.2))
                                    .at(0, 3, 0)
                                    .symbol("colour of mood", "blue")
                                    .physics("mass", random.nextDouble())
                                    .build());
            case 3 -> world.add(ItemDefinition.named("flag " + frame).at(1, 2, 3).build());
            case 4 ->
                    world.find("flag " + (frame - 1))
                            .ifPresent(flag -> world.attach(flag.id(), corner.id()));
            case 5 -> world.find("ball " + (frame - 14)).ifPresent(ball -> world.remove(ball.id()));
            case 6 ->
                    world.find("ball " + (frame - 5))
                            .ifPresent(ball -> world.rename(ball.id(), "old ball " + frame));
            case 8 ->
                    world.forces()
                            .add(
                                    new Force(
                                            corner.id(),
                                            List.of(random.nextGaussian(), 3.0, 0.0),
                                            1 + random.nextInt(5)));
            case 7 ->
                    world.table("body")
                            .column("dragCoefficient")
                            .setDouble(random.nextInt(10), 0, 0.25);
            default -> {}
        }
        var laws = simulation.physics().laws();
        if (frame == 40) {
            laws.load(frame, "drag", Map.of());
        }
        if (frame == 80) {
            laws.unload(frame, laws.loaded().getLast().libraryId());
        }
    }

    /** Copies the recording with one text of its inputs replaced, and valid checksums. */
    private void forge(Path to, String text, String other) throws IOException {
        try (RunLog.Reader records = RunLog.open(log);
                JournalSink sink = new Recording(RecordingPlan.of(to))) {
            while (records.hasNext()) {
                JournalRecord record = records.next();
                sink.write(
                        record instanceof JournalRecord.Frame frame
                                ? new JournalRecord.Frame(
                                        frame.frame(),
                                        new String(frame.json(), StandardCharsets.UTF_8)
                                                .replace(text, other)
                                                .getBytes(StandardCharsets.UTF_8))
                                : record);
            }
        }
    }
}
