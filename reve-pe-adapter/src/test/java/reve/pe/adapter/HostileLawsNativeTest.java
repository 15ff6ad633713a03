// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.world.WorldEvent;
import reve.pe.PhysicsException;
import reve.pe.PreparedLibrary;
import reve.pe.Status;

import java.util.List;
import java.util.Map;
import java.util.Random;

/**
 * Laws that harm their process (src/test/native/hostile.c). Before the fault, each law pushes every
 * body with 1 N, as the law "wind" does. Therefore the expected world has the law "wind" until the
 * fault.
 */
@Tag("slow")
class HostileLawsNativeTest {
    private static final int BAD_FRAME = 13; // whose steps are 48 to 51
    private static final int FRAMES = 20;

    @ParameterizedTest
    @CsvSource({
        "segfault, LAW_CRASHED, SIGSEGV",
        "abort, LAW_CRASHED, SIGABRT",
        "exit, LAW_CRASHED, exit code 3",
        "_exit, LAW_CRASHED, exit code 4",
        "exit_0, LAW_CRASHED, exit code 0",
        "overflow, LAW_CRASHED, SIGSEGV",
        "far_write, LAW_CRASHED, SIGSEGV",
        "write_before, LAW_CRASHED, SIGSEGV",
        "const_write, LAW_CRASHED, 'SIGSEGV; it wrote property mass, row 0, which no loaded law'",
        "wild_then_crash, LAW_CRASHED, SIGSEGV",
        "close_all_then_crash, LAW_CRASHED, SIGABRT",
        "fork_bomb_then_crash, LAW_CRASHED, SIGABRT",
        "kill, LAW_CRASHED, SIGKILL",
        "handler_ignores, LAW_CRASHED, SIGABRT",
        "memory, LAW_CRASHED, SIGSEGV",
        "divide, LAW_CRASHED, SIGFPE",
        "illegal, LAW_CRASHED, SIGILL",
        "free_twice, LAW_CRASHED, SIGABRT",
        "loop, LAW_TIMED_OUT, no answer within",
        "sleep, LAW_TIMED_OUT, no answer within",
        "deadlock, LAW_TIMED_OUT, no answer within",
        "pthread_exit, LAW_CRASHED, SIGABRT",
        "stop, LAW_TIMED_OUT, no answer within",
        "handler_loops, LAW_TIMED_OUT, no answer within",
        "exec, LAW_TIMED_OUT, no answer within",
    })
    void aLawThatEndsItsProcessCostsOneRepeatedFrame(String kind, Status status, String how) {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion");
            expected.load("newton_motion");
            hosted.world.adapter.laws().load(0, "hostile_" + kind, Map.of());
            int wind = expected.adapter.laws().load(0, "wind", Map.of());
            for (int frame = 1; frame <= FRAMES; frame++) {
                if (frame == BAD_FRAME) {
                    expected.adapter.laws().unload(frame, wind);
                }
                expected.run(1);
                hosted.world.run(1);
                assertThat(differing(hosted.world, expected)).as("frame " + frame).isEmpty();
                assertThat(hosted.world.adapter.stateHash())
                        .isEqualTo(expected.adapter.stateHash());
            }
            // SIGKILL may come from outside. Therefore only the fifth SIGKILL in a frame counts as
            // the law's fault.
            assertThat(hosted.world.adapter.profile().redoneFrames())
                    .isEqualTo(kind.equals("kill") ? 5 : 1);
            WorldEvent fault = hosted.world.events("fault").getFirst();
            assertThat(hosted.world.events("fault")).hasSize(1);
            assertThat(fault.frame()).isEqualTo(BAD_FRAME);
            assertThat(fault.fields())
                    .containsEntry("library", "hostile")
                    .containsEntry("law", "hostile")
                    .containsEntry("status", status.name());
            assertThat(fault.fields().get("message"))
                    .asString()
                    .startsWith("law hostile: ")
                    .contains(how);
            try (PreparedLibrary again = hosted.world.engine.prepare("hostile_" + kind)) {
                assertThatExceptionOfType(PhysicsException.class)
                        .isThrownBy(() -> hosted.world.adapter.laws().load(FRAMES, again, Map.of()))
                        .withMessageContaining("in quarantine since frame " + BAD_FRAME);
            }
        }
    }

    /**
     * These laws harm only the process of the engine, which continues. They do not disturb the
     * world.
     */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "close_all",
                "alarm",
                "itimer",
                "terminate",
                "fork",
                "quiet_thread",
                "stop_once",
                "print"
            })
    void aLawThatHarmsNothingElseActsOn(String kind) {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "hostile_" + kind);
            expected.load("newton_motion", "wind");
            for (int frame = 1; frame <= FRAMES; frame++) {
                expected.run(1);
                hosted.world.run(1);
                assertThat(differing(hosted.world, expected)).as("frame " + frame).isEmpty();
            }
            assertThat(hosted.world.events("fault")).isEmpty();
            unload(hosted.world, "hostile");
            unload(expected, "wind");
            for (int frame = 1; frame <= FRAMES; frame++) {
                expected.run(1);
                hosted.world.run(1);
                assertThat(differing(hosted.world, expected)).isEmpty();
            }
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

    private static void unload(AdapterFixture world, String library) {
        int id =
                world.adapter.laws().loaded().stream()
                        .filter(law -> law.library().equals(library))
                        .findFirst()
                        .orElseThrow()
                        .libraryId();
        world.adapter.laws().unload(FRAMES, id);
    }

    /** The number of crashes. They are of four kinds, and a seed chooses their frames. */
    private static final int CRASHES = Integer.getInteger("reve.test.crashes", 40);

    @Test
    void everyCrashOfManyLeavesTheWorldThatNeverHadTheLaw() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            Random random = new Random(19);
            hosted.world.load("newton_motion").run(BAD_FRAME);
            expected.load("newton_motion").run(BAD_FRAME);
            String[] kinds = {"segfault", "abort", "_exit", "overflow"};
            for (int crash = 0; crash < CRASHES; crash++) {
                int frames = random.nextInt(4);
                hosted.world.run(frames).load("hostile_" + kinds[crash % kinds.length]).run(1);
                expected.run(frames + 1);
                assertThat(hosted.world.events("fault")).hasSize(crash + 1);
                assertThat(hosted.world.adapter.stateHash())
                        .isEqualTo(expected.adapter.stateHash());
                hosted.world
                        .adapter
                        .laws()
                        .quarantined()
                        .forEach(out -> hosted.world.adapter.laws().release(out.sha256()));
            }
            assertThat(differing(hosted.world, expected)).isEmpty();
            assertThat(hosted.world.adapter.profile().redoneFrames()).isEqualTo(CRASHES);
        }
    }

    /** The number of hangs. They are of three kinds. The fault model requires 100. */
    private static final int HANGS = Integer.getInteger("reve.test.hangs", 6);

    /**
     * Each law acts in three frames before it hangs, because its first frames have a longer limit.
     */
    @Test
    void everyHangOfManyLeavesTheWorldThatNeverHadTheLaw() {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion");
            expected.load("newton_motion");
            String[] kinds = {"loop", "sleep", "deadlock"};
            for (int hang = 0; hang < HANGS; hang++) {
                for (AdapterFixture world : List.of(hosted.world, expected)) {
                    world.engine.setStepCount(36, 1.0 / 240);
                }
                hosted.world.load("hostile_" + kinds[hang % kinds.length]).run(3);
                expected.load("wind").run(3);
                assertThat(hosted.world.events("fault")).hasSize(hang);
                unload(expected, "wind");
                hosted.world.run(1); // its steps are 48 to 51
                expected.run(1);
                assertThat(hosted.world.events("fault")).hasSize(hang + 1);
                assertThat(hosted.world.events("fault").getLast().fields())
                        .containsEntry("status", "LAW_TIMED_OUT")
                        .hasEntrySatisfying(
                                "message",
                                message ->
                                        assertThat(String.valueOf(message))
                                                .contains("no answer within"));
                assertThat(hosted.world.adapter.stateHash())
                        .isEqualTo(expected.adapter.stateHash());
                hosted.world
                        .adapter
                        .laws()
                        .quarantined()
                        .forEach(out -> hosted.world.adapter.laws().release(out.sha256()));
            }
            assertThat(differing(hosted.world, expected)).isEmpty();
            assertThat(hosted.world.adapter.profile().redoneFrames()).isEqualTo(HANGS);
        }
    }

    /**
     * Two laws run at the same time. The frame is repeated on one thread, which shows the law that
     * crashed.
     */
    @Test
    void theRightOneOfLawsThatRunAtOnceIsBlamed() {
        try (HostedFixture hosted = new HostedFixture(2);
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "wind", "hostile_segfault").run(FRAMES);
            expected.load("newton_motion");
            int both = expected.adapter.laws().load(0, "wind", Map.of("force", 2.0));
            expected.run(BAD_FRAME - 1);
            expected.adapter.laws().unload(BAD_FRAME, both);
            expected.load("wind").run(FRAMES - BAD_FRAME + 1);
            assertThat(hosted.world.events("fault"))
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields()).containsEntry("library", "hostile"));
            assertThat(differing(hosted.world, expected)).isEmpty();
        }
    }

    /**
     * A thread that outlives its law ends with its process, because the unload replaces the
     * process.
     */
    @Test
    void nothingWritesAfterItsLawWasUnloaded() throws InterruptedException {
        try (HostedFixture hosted = new HostedFixture()) {
            hosted.world.load("newton_motion", "hostile_wild_thread").run(BAD_FRAME);
            unload(hosted.world, "hostile");
            hosted.world.run(1);
            var after = hosted.world.bytes();
            Thread.sleep(50);
            assertThat(hosted.world.bytes()).isEqualTo(after);
        }
    }

    @ParameterizedTest
    @CsvSource({
        "constructor, opening it",
        "entry, opening it",
        "create, creating or destroying its laws",
        "destroy, creating or destroying its laws",
        "destructor, opening it",
    })
    void aLawThatEndsItsProcessOutsideOfStepsIsNeverLoaded(String place, String stage) {
        try (HostedFixture hosted = new HostedFixture()) {
            hosted.world.load("newton_motion").run(1);
            for (String kind : new String[] {"segfault", "_exit"}) {
                assertThatExceptionOfType(PhysicsException.class)
                        .isThrownBy(() -> hosted.world.load("hostile_" + kind + "_in_" + place))
                        .satisfies(
                                refused ->
                                        assertThat(refused.status())
                                                .isEqualTo(Status.LIBRARY_LOAD_FAILED))
                        .withMessageContaining(
                                "libvesper_law_hostile_" + kind + "_in_" + place + ".so")
                        .withMessageContaining("while " + stage);
            }
            hosted.world.run(1);
            assertThat(hosted.world.adapter.profile().redoneFrames()).isZero();
        }
    }

    @ParameterizedTest
    @ValueSource(strings = {"segfault", "_exit", "loop"})
    void aLawThatEndsItsProcessWhenItIsBoundCostsOneRepeatedFrame(String kind) {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion").run(1);
            expected.load("newton_motion").run(2);
            hosted.world.load("hostile_" + kind + "_in_bind").run(1);
            assertThat(differing(hosted.world, expected)).isEmpty();
            assertThat(hosted.world.events("fault"))
                    .singleElement()
                    .satisfies(fault -> assertThat(fault.fields()).containsEntry("law", "hostile"));
        }
    }
}
