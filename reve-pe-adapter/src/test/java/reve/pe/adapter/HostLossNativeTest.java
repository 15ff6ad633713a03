// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.WorldImage;
import reve.pe.NativeFiles;
import reve.pe.PhysicsException;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.nio.file.attribute.PosixFilePermissions;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Random;

/** Losses of the engine's process. Their cause is no law, or not the law that runs at that time. */
@Tag("slow")
class HostLossNativeTest {
    private static final int BAD_FRAME = 13; // whose steps are 48 to 51
    private static final int FRAMES = 20;
    private static final int REWINDS = Integer.getInteger("reve.test.rewinds", 15);
    private static final long SEED = 20261128;

    /** Number of frames after which laws have built the data that they need. */
    private static final int SETTLED = 3;

    @TempDir private Path folder;

    /** A program that is a host. If a certain file exists, it ends instead. */
    private final class Program {
        final Path file = folder.resolve("host");
        private final Path broken = folder.resolve("broken");

        Program() throws IOException {
            Files.writeString(
                    file,
                    "#!/bin/sh\n[ -e "
                            + broken
                            + " ] && kill -9 $$\nexec "
                            + NativeFiles.program("vesper-host")
                            + " \"$@\"\n");
            allow("rwx------");
        }

        void fail(String how) throws IOException {
            if (how.equals("refused")) {
                allow("rw-------");
            } else {
                Files.createFile(broken);
            }
        }

        void recover() throws IOException {
            allow("rwx------");
            Files.deleteIfExists(broken);
        }

        private void allow(String permissions) throws IOException {
            Files.setPosixFilePermissions(file, PosixFilePermissions.fromString(permissions));
        }
    }

    /**
     * The law acts like another program that kills the process, such as the system when memory is
     * short.
     */
    @Test
    void aProcessThatIsKilledFromOutsideTakesNoLaw() throws IOException {
        Path mark = Path.of("/tmp/reve-kill-once-" + ProcessHandle.current().pid());
        Files.deleteIfExists(mark);
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "hostile_kill_once").run(FRAMES);
            expected.load("newton_motion", "wind").run(FRAMES);
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.adapter.profile().redoneFrames()).isOne();
            assertThat(differing(hosted.world, expected)).isEmpty();
        } finally {
            Files.delete(mark);
        }
    }

    /**
     * Frames without a process have no physics. The same is true in the world that repeats the
     * changes.
     */
    @ParameterizedTest
    @ValueSource(strings = {"refused", "killed"})
    void aSystemThatStartsNoProcessTakesNoLaw(String how) throws IOException {
        Program program = new Program();
        List<LawChange> changes = new ArrayList<>();
        try (HostedFixture hosted = new HostedFixture(1, program.file);
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "wind");
            expected.load("newton_motion", "wind");
            hosted.world.adapter.laws().addListener(changes::add);
            for (int frame = 1; frame <= FRAMES; frame++) {
                if (frame == 5) {
                    program.fail(how);
                } else if (frame == 10) {
                    program.recover();
                }
                if (frame >= 5 && frame < 10) {
                    killHosts();
                }
                hosted.world.run(1);
                for (LawChange change : List.copyOf(changes)) {
                    expected.adapter.laws().apply(frame, change);
                }
                expected.run(1);
                assertThat(differing(hosted.world, expected)).as("frame " + frame).isEmpty();
                if (frame < 9) {
                    assertThat(changes).allMatch(LawChange.Unmoved.class::isInstance);
                } else if (frame == 9) {
                    assertThat(changes).containsExactly(new LawChange.Unmoved());
                } else {
                    assertThat(changes).isEmpty();
                }
                changes.clear();
            }
            assertThat(hosted.world.adapter.laws().quarantined()).isEmpty();
            assertThat(hosted.world.adapter.stateHash()).isEqualTo(expected.adapter.stateHash());
        }
    }

    @Test
    void aNewProcessSkipsTheStepsThatTheLastOneSkipped() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            for (AdapterFixture world : List.of(hosted.world, expected)) {
                world.load("newton_motion", "wind");
                Laws laws = world.adapter.laws();
                laws.setInterval(laws.latest().orElseThrow().getKey(), 3);
            }
            expected.run(FRAMES);
            hosted.world.run(BAD_FRAME);
            killHosts();
            hosted.world.run(FRAMES - BAD_FRAME);
            assertThat(differing(hosted.world, expected)).isEmpty();
        }
    }

    /** Processes are killed while the world goes from one set of laws to another one and back. */
    @Test
    void aRewindHappensWholeOrNotAtAll() throws Exception {
        Program program = new Program();
        try (HostedFixture hosted = new HostedFixture(1, program.file);
                AdapterFixture expected = HostedFixture.inProcess();
                Rewinds hostedRewinds = new Rewinds(hosted.world);
                Rewinds expectedRewinds = new Rewinds(expected)) {
            int refused = 0;
            Random random = new Random(SEED);
            for (int rewind = 0; rewind < REWINDS; rewind++) {
                int target = random.nextInt(2);
                boolean isBroken = rewind % 5 == 4;
                if (isBroken) {
                    program.fail(rewind % 2 == 0 ? "killed" : "refused");
                    killHosts();
                }
                Thread killer = isBroken ? null : killsHosts(random.nextInt(2, 40));
                try {
                    hostedRewinds.to(target);
                    expectedRewinds.to(target);
                } catch (PhysicsException | IllegalStateException why) {
                    refused++;
                }
                if (killer == null) {
                    program.recover();
                } else {
                    killer.interrupt();
                    killer.join();
                }
                assertThat(hosted.world.adapter.laws().libraries())
                        .as("rewind %d", rewind)
                        .usingRecursiveComparison()
                        .isEqualTo(expected.adapter.laws().libraries());
                for (AdapterFixture world : List.of(hosted.world, expected)) {
                    world.run(2);
                }
                assertThat(differing(hosted.world, expected)).as("rewind %d", rewind).isEmpty();
                assertThat(hosted.world.adapter.stateHash())
                        .as("rewind %d", rewind)
                        .isEqualTo(expected.adapter.stateHash());
            }
            assertThat(refused).isGreaterThanOrEqualTo(REWINDS / 5);
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.adapter.laws().quarantined()).isEmpty();
        }
    }

    /** Two images of a world with different laws: one with SCRATCH, one that arrests no item. */
    private static final class Rewinds implements AutoCloseable {
        private final AdapterFixture world;
        private final List<WorldImage> images = new ArrayList<>();
        private final List<PhysicsImage> physics = new ArrayList<>();

        Rewinds(AdapterFixture world) {
            this.world = world;
            world.load("newton_motion", "counts_years").run(3);
            keep();
            Laws laws = world.adapter.laws();
            laws.unload(3, laws.byId().keySet().iterator().next());
            world.load("drag", "newton_motion", "wind").run(3);
            world.world.remove(world.world.find("b3").orElseThrow().id());
            world.run(1);
            keep();
        }

        private void keep() {
            WorldImage image = new WorldImage(world.world);
            images.add(image);
            image.copyFrom(world.world, world.loop.frame());
            physics.add(world.adapter.save());
        }

        void to(int image) {
            world.adapter.restore(
                    world.loop.frame() + 1,
                    physics.get(image),
                    () -> world.world.restore(images.get(image)));
            world.loop.continueAfter(world.loop.frame() + 1);
        }

        @Override
        public void close() {
            images.forEach(WorldImage::close);
        }
    }

    /** Returns a thread that kills all hosts, again and again, until it is interrupted. */
    private static Thread killsHosts(int milliseconds) {
        return Thread.ofPlatform()
                .start(
                        () -> {
                            try {
                                while (true) {
                                    Thread.sleep(milliseconds);
                                    hosts().forEach(ProcessHandle::destroyForcibly);
                                }
                            } catch (InterruptedException end) {
                                // the rewind has ended
                            }
                        });
    }

    /** In this case the engine has made the steps but has no memory for its answer. */
    @Test
    void anEngineWithoutMemoryIsReplacedBeforeALawIsBlamed() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "counts_years", "hostile_hoard");
            expected.load("newton_motion", "counts_years");
            int wind = expected.adapter.laws().load(0, "wind", Map.of());
            for (int frame = 1; frame <= FRAMES; frame++) {
                if (frame == BAD_FRAME) {
                    expected.adapter.laws().unload(frame, wind);
                }
                expected.run(1);
                hosted.world.run(1);
                assertThat(differing(hosted.world, expected)).as("frame " + frame).isEmpty();
            }
            assertThat(hosted.world.adapter.stateHash()).isEqualTo(expected.adapter.stateHash());
            assertThat(hosted.world.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields())
                                            .containsEntry("library", "hostile")
                                            .containsEntry("status", "ENGINE_LOST"));
        }
    }

    /**
     * The law builds data for longer than a frame may take. It does so when it is new, in a new
     * process, for more rows, and in a rewind.
     */
    @Test
    void lawsHaveTimeToBuild() {
        try (HostedFixture hosted = new HostedFixture()) {
            AdapterFixture world = hosted.world;
            world.load("newton_motion").run(SETTLED);
            world.load("hostile_build").run(SETTLED);
            PhysicsImage before = world.adapter.save();
            world.run(SETTLED);
            killHosts();
            world.run(SETTLED);
            world.world.add(AdapterFixture.body("more", 1, 50, 0, 0, 0, 0, 0));
            world.run(SETTLED);
            world.adapter.restore(world.loop.frame(), before, () -> {});
            world.run(SETTLED);
            assertThat(world.events("fault")).isEmpty();
        }
    }

    /**
     * The watchdog ends the server if a frame takes 5 s. The limit includes all laws of the frame
     * that do not return.
     */
    @Test
    void lawsThatLoopInOneFrameTakeLessTimeThanAWatchdog() {
        String rest = "";
        for (int attempt = 0; attempt < 3 && !rest.matches(MOST_OF_A_SECOND); attempt++) {
            try (HostedFixture hosted = new HostedFixture()) { // again if the machine was busy
                hosted.world.load(
                        "newton_motion", "hostile_loop_in_bind", "hostile_other_loop_in_bind");
                hosted.world.run(1);
                List<String> messages =
                        hosted.world.events("fault").stream()
                                .map(fault -> fault.fields().get("message").toString())
                                .toList();
                assertThat(messages)
                        .hasSize(2)
                        .startsWith("law hostile: no answer within 3000 ms of its frame");
                rest = messages.getLast();
            }
        }
        assertThat(rest).matches(MOST_OF_A_SECOND);
    }

    /** The second process needs some of the last second to load the laws. */
    private static final String MOST_OF_A_SECOND =
            "law hostile: no answer within (9..|1000) ms of its frame";

    /** The first law crashes after 2.6 s of the 4 s in which a frame may fail. */
    @Test
    void timeBeforeACrashReducesTheTimeOfOtherLawsInTheFrame() {
        try (HostedFixture hosted = new HostedFixture()) {
            hosted.world.load(
                    "newton_motion", "hostile_late_segfault_in_bind", "hostile_other_loop_in_bind");
            hosted.world.run(1);
            assertThat(hosted.world.events("fault"))
                    .extracting(fault -> fault.fields().get("message").toString())
                    .hasSize(2)
                    .anyMatch(message -> message.contains("SIGSEGV"))
                    .anyMatch(message -> message.matches(".*no answer within [12]... ms.*"));
        }
    }

    /**
     * The time in which laws build data in their first frame does not lengthen the deadline of
     * later frames.
     */
    @Test
    void theDeadlineGrowsWithFramesInWhichLawsBuildNothing() {
        try (HostedFixture hosted = new HostedFixture()) {
            hosted.world.load("newton_motion", "hostile_build", "hostile_other_loop_in_advance");
            hosted.world.run(BAD_FRAME);
            assertThat(hosted.world.events("fault"))
                    .extracting(fault -> fault.fields().get("message"))
                    .containsExactly("law hostile: no answer within 300 ms of its frame");
        }
    }

    /** Returns the names of the columns that differ. */
    private static List<String> differing(AdapterFixture one, AdapterFixture other) {
        var bytes = other.bytes();
        return one.bytes().entrySet().stream()
                .filter(column -> !column.getValue().equals(bytes.get(column.getKey())))
                .map(Map.Entry::getKey)
                .toList();
    }

    private static void killHosts() {
        List<ProcessHandle> doomed = hosts();
        doomed.forEach(ProcessHandle::destroyForcibly);
        doomed.forEach(host -> host.onExit().join());
    }

    private static List<ProcessHandle> hosts() {
        return ProcessHandle.current()
                .children()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .toList();
    }
}
