// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.Status;
import reve.pe.vesper.VesperEngine;
import reve.worlds.journal.Journal;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;

import java.io.IOException;
import java.lang.reflect.InvocationTargetException;
import java.lang.reflect.Proxy;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.ConcurrentLinkedQueue;

/** Journals of worlds whose engine fails. */
@Tag("slow")
@Timeout(value = 600, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class EngineFailureNativeTest {
    private static final Path WORLD =
            Path.of(System.getProperty("reve.root"), "worlds", "spring-orbit", "world.yaml");
    private static final int END = 30;

    private final List<List<JournalRecord>> records =
            Collections.synchronizedList(new ArrayList<>());
    private final Queue<String> problems = new ConcurrentLinkedQueue<>();
    private WorldDescription description;

    /** The name of the engine's method that fails with {@code failure}. */
    private String failing = "";

    private RuntimeException failure = new IllegalStateException("no process can be started");

    @BeforeEach
    void read() throws Exception {
        description = WorldFile.load(WORLD);
    }

    /** The engine has no process in these frames. No law is the cause. */
    @Test
    void framesWithoutPhysicsAreRepeatedWithoutIt() throws IOException {
        long hash =
                run(
                        0,
                        (simulation, frame) -> {
                            failing = frame >= 10 && frame < 13 ? "advance" : "";
                            if (frame == 11) {
                                simulation.physics().laws().load(frame, "drag", Map.of());
                            }
                        });
        repeated(hash).close();
    }

    @Test
    void aReleaseFromQuarantineIsRepeated() throws IOException {
        long hash = run(0, this::failTwice);
        try (Simulation again = repeated(hash)) {
            assertThat(again.physics().laws().quarantined()).isEmpty();
        }
    }

    /** Journals of earlier versions have no releases of laws. */
    @Test
    void aLibraryThatWasLoadedWasReleased() throws IOException {
        long hash = run(0, this::failTwice);
        records.replaceAll(
                slot -> slot.stream().map(EngineFailureNativeTest::withoutReleases).toList());
        repeated(hash).close();
    }

    /** The number of images that cannot be copied is larger than the number of slots. */
    @Test
    void imagesThatCannotBeCopiedLeaveAWholeStore() throws IOException {
        long hash =
                run(
                        3,
                        (simulation, frame) -> {
                            failing = frame >= 5 && frame < 20 ? "saveState" : "";
                            if (frame == 7) {
                                simulation
                                        .world()
                                        .find("red")
                                        .orElseThrow()
                                        .physics()
                                        .set("velocity", 0, 1, 0);
                            }
                        });
        assertThat(problems)
                .containsExactly(
                        "the image of frame 6 could not be copied: no process can be started; the"
                                + " next frame tries again");
        repeated(hash).close();
    }

    /** Each failed attempt would otherwise count as one of the images that are kept. */
    @Test
    void anImageThatCannotBeCopiedIsNotKept() throws IOException {
        int[] failures = {0};
        run(
                0,
                (simulation, frame) -> {
                    failing = frame >= 5 && frame < 20 ? "saveState" : "";
                    while (frame == 7 && failures[0] < 100) {
                        assertThatIllegalStateException()
                                .isThrownBy(simulation::keep)
                                .withMessage("no process can be started");
                        failures[0]++;
                    }
                    assertThat(simulation.hasRoomForImage()).isTrue();
                });
        assertThat(failures[0]).isEqualTo(100);
    }

    private interface Interference {
        void before(Simulation simulation, long frame);
    }

    /** A law fails, is released, loaded again, fails again and is released. */
    private void failTwice(Simulation simulation, long frame) {
        var laws = simulation.physics().laws();
        failing = "";
        if (frame == 10 || frame == 20) {
            int id = laws.load(frame, "drag", Map.of());
            failure =
                    new PhysicsException(
                            Status.LAW_FAILED, id, "drag", "drag", "", -1, "as the test wants");
            failing = "advance";
        } else if (frame == 15 || frame == 25) {
            laws.release(laws.quarantined().getFirst().sha256());
        }
    }

    /**
     * Runs the world, and returns its last hash.
     *
     * @param imageFrames frames between two images; 0: only the first
     */
    private long run(int imageFrames, Interference interference) throws IOException {
        LawPath shipped = LawPath.ofShipped();
        LawPath laws =
                new LawPath(
                        shipped.shipped(),
                        Optional.empty(),
                        Optional.empty(),
                        false,
                        (config, prototype, apart, arena) ->
                                failing(new VesperEngine(config, prototype)),
                        false,
                        Set.of(),
                        Sandboxed.NONE);
        try (Simulation simulation = new Simulation(description, Pacing.FAST, laws);
                Journal _ =
                        simulation.journal(
                                WORLD.getParent(),
                                Map.of(),
                                new Journal.Plan(imageFrames, true),
                                new Memory(),
                                problems::add)) {
            simulation.loop().run(0);
            while (simulation.loop().frame() < END) {
                interference.before(simulation, simulation.loop().frame());
                simulation.loop().step();
            }
            failing = "";
            return simulation.physics().stateHash();
        }
    }

    /** Returns an engine that fails as {@link #failing} says. A law fails only once. */
    private PhysicsEngine failing(PhysicsEngine engine) {
        return (PhysicsEngine)
                Proxy.newProxyInstance(
                        PhysicsEngine.class.getClassLoader(),
                        new Class<?>[] {PhysicsEngine.class},
                        (proxy, method, arguments) -> {
                            if (method.getName().equals(failing)) {
                                if (failure instanceof PhysicsException) {
                                    failing = "";
                                }
                                throw failure;
                            }
                            try {
                                return method.invoke(engine, arguments);
                            } catch (InvocationTargetException e) {
                                throw e.getCause();
                            }
                        });
    }

    /** Repeats all frames from the first image, and returns the world. */
    private Simulation repeated(long hash) throws IOException {
        try (Replay replay = new Replay(Optional.empty(), Pacing.FAST)) {
            boolean begun = false;
            for (JournalRecord record : records.stream().flatMap(List::stream).toList()) {
                if (!begun || !(record instanceof JournalRecord.Image)) {
                    assertThat(replay.take(record)).as(replay.divergence().toString()).isTrue();
                }
                begun |= record instanceof JournalRecord.Image;
            }
            assertThat(replay.frame()).isEqualTo(END);
            Simulation again = replay.release();
            assertThat(again.physics().stateHash()).isEqualTo(hash);
            return again;
        }
    }

    private static JournalRecord withoutReleases(JournalRecord record) {
        return record instanceof JournalRecord.Frame frame
                ? new JournalRecord.Frame(
                        frame.frame(),
                        new String(frame.json(), StandardCharsets.UTF_8)
                                .replaceAll("\"laws\":\\[\\{\"law\":\"released\"[^}]*\\}\\],", "")
                                .getBytes(StandardCharsets.UTF_8))
                : record;
    }

    /** A journal in memory. */
    private final class Memory implements JournalSink {
        @Override
        public void write(JournalRecord record) {
            records.add(List.of(record));
        }

        @Override
        public Place place() {
            List<JournalRecord> place = Collections.synchronizedList(new ArrayList<>());
            records.add(place);
            return (libraries, image) -> {
                place.addAll(libraries);
                place.add(image);
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
}
