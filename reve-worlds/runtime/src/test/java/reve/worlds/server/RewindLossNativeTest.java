// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.SimulationImage;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.StoreContents;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.locks.Lock;
import java.util.concurrent.locks.LockSupport;
import java.util.concurrent.locks.ReadWriteLock;
import java.util.concurrent.locks.ReentrantReadWriteLock;
import java.util.function.BooleanSupplier;
import java.util.stream.Stream;

/** A world rewinds while a slow disk still writes two images of earlier frames. */
@Tag("slow")
class RewindLossNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "spring-orbit", "world.yaml");
    private static final LawPath LAWS = LawPath.ofShipped();
    private static final String NAME = "my.db";
    private static final int IMAGE_FRAMES = 3;

    /** The frame of the rewind. At this frame the images of frames 3 and 6 still wait. */
    private static final long BACK = 8;

    private static final long END = 16;

    @TempDir private Path folder;
    private final Queue<String> problems = new ConcurrentLinkedQueue<>();

    /**
     * The files that remain if the process is killed just after a frame was published, by frame.
     */
    private final Map<Long, Path> copies = new LinkedHashMap<>();

    private WorldDescription description;
    private volatile boolean isGoingBack;
    private volatile long published;

    @BeforeEach
    void read() throws Exception {
        description = WorldFile.load(WORLD);
    }

    @ParameterizedTest
    @ValueSource(booleans = {true, false})
    void atMostOnePublishedFrameIsLostByAKillAfterGoingBack(boolean waits) throws Exception {
        Thread world = Thread.currentThread();
        run(
                waits,
                () ->
                        isGoingBack
                                && (published > BACK
                                        || world.getState() == Thread.State.TIMED_WAITING));

        assertThat(copies.keySet()).contains(BACK - 1, BACK, BACK + 1, END);
        for (Map.Entry<Long, Path> copy : copies.entrySet()) {
            StoreCheck left =
                    StoreCheck.of(new StoreAddress.InFile(copy.getValue().resolve(NAME)), LAWS);
            assertThat(left.isWhole()).as(left.toString()).isTrue();
            assertThat(left.frame())
                    .as("killed as frame " + copy.getKey() + " was published")
                    .isBetween(copy.getKey() - 1, copy.getKey());
        }
        assertThat(problems).isEmpty();
    }

    /** The world waits once and continues, and the next image replaces the missing frames. */
    @Test
    void aDiskThatHangsForLongerIsReportedOnce() throws Exception {
        run(false, () -> published > BACK + 2);

        assertThat(problems)
                .containsExactly(
                        "the disk is too slow: frames from "
                                + BACK
                                + " on are omitted, up to the next image");
        StoreContents left = StoreContents.read(folder.resolve(NAME));
        assertThat(left.isWhole()).as(left.problems().toString()).isTrue();
        assertThat(left.frame()).isEqualTo(END);
    }

    /**
     * Makes all frames. Laws change before and after the rewind.
     *
     * @param isReleased whether images after the first one may be written
     */
    private void run(boolean waits, BooleanSupplier isReleased) throws IOException {
        StoredWorld stored =
                StoredWorld.open(
                        new StoreAddress.InFile(folder.resolve(NAME)),
                        SqliteStore.Durability.NORMAL,
                        description,
                        Path.of("."),
                        Pacing.FAST,
                        LAWS,
                        problems::add);
        var sink = new SlowStore(stored.store(), isReleased);
        try (Simulation simulation = stored.simulation();
                SimulationImage beginning = simulation.beginning()) {
            simulation.onPublish("before", frame -> isGoingBack |= frame.frame() == BACK);
            Journal journal =
                    simulation.journal(
                            WORLD.getParent(),
                            Map.of(),
                            new Journal.Plan(IMAGE_FRAMES, waits),
                            sink,
                            problems::add);
            try {
                simulation
                        .bus()
                        .subscribe(FramePhase.PUBLISH, "agents", frame -> published(frame, sink));
                makeFrames(simulation, beginning);
            } finally {
                journal.close();
            }
            assertThat(journal.shortfall()).isEmpty();
        }
    }

    private static void makeFrames(Simulation simulation, SimulationImage beginning) {
        while (simulation.loop().frame() < END) {
            long frame = simulation.loop().frame();
            if (frame == 4 || frame == BACK + 1) {
                simulation.physics().laws().load(frame, "drag", Map.of());
            } else if (frame == BACK - 1) {
                assertThat(simulation.rewind(beginning)).isEqualTo(BACK);
            }
            simulation.loop().step();
        }
    }

    private void published(FrameEvent frame, SlowStore sink) {
        try {
            if (frame.frame() > 0) { // before that, the store is empty
                copies.put(frame.frame(), sink.copy());
            }
        } catch (IOException e) {
            problems.add(e.toString());
        }
        published = frame.frame();
    }

    /** A store that writes only the first image until it is released. */
    private final class SlowStore implements JournalSink {
        private final JournalSink store;
        private final BooleanSupplier isReleased;

        /** Either any number of threads write the files, or one thread copies them. */
        private final ReadWriteLock files = new ReentrantReadWriteLock();

        private boolean begun;

        private interface Step<T> {
            T run() throws IOException;
        }

        SlowStore(JournalSink store, BooleanSupplier isReleased) {
            this.store = store;
            this.isReleased = isReleased;
        }

        @Override
        public void write(JournalRecord record) throws IOException {
            holding(
                    files.readLock(),
                    () -> {
                        store.write(record);
                        return record;
                    });
        }

        @Override
        public Place place() throws IOException {
            Place place = holding(files.readLock(), store::place);
            boolean isFirst = !begun;
            begun = true;
            return (libraries, image) -> {
                while (!isFirst && !isReleased.getAsBoolean()) {
                    LockSupport.parkNanos(10_000);
                }
                holding(
                        files.readLock(),
                        () -> {
                            place.write(libraries, image);
                            return image;
                        });
            };
        }

        @Override
        public void sync() throws IOException {
            store.sync();
        }

        @Override
        public void close() throws IOException {
            store.close();
        }

        /** Returns a copy of the files between two writes. */
        Path copy() throws IOException {
            return holding(
                    files.writeLock(),
                    () -> {
                        Path to = Files.createTempDirectory(folder, "killed");
                        try (Stream<Path> all = Files.list(folder)) {
                            for (Path file : all.filter(Files::isRegularFile).toList()) {
                                Files.copy(file, to.resolve(file.getFileName()));
                            }
                        }
                        return to;
                    });
        }

        private static <T> T holding(Lock lock, Step<T> step) throws IOException {
            lock.lock();
            try {
                return step.run();
            } finally {
                lock.unlock();
            }
        }
    }
}
