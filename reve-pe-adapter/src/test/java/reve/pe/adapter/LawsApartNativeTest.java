// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.world.WorldEvent;
import reve.pe.NativeFiles;
import reve.pe.PhysicsException;
import reve.pe.Status;
import reve.pe.hosted.ApartRule;

import java.util.Map;
import java.util.Set;
import java.util.stream.Collectors;

/** Laws that run in a sandbox beside the engine's process. */
@Tag("slow")
class LawsApartNativeTest {
    private static final int BAD_FRAME = 13; // whose steps are 48 to 51
    private static final int FRAMES = 20;
    private static final ApartRule HOSTILE =
            (file, library) ->
                    file.map(path -> path.toString().contains("hostile")).orElse(false)
                            ? ApartRule.Isolation.APART
                            : ApartRule.Isolation.NONE;

    private static HostedFixture apart(ApartRule rule) {
        return new HostedFixture(1, NativeFiles.program("vesper-host"), rule);
    }

    private static Set<Long> hosts() {
        return ProcessHandle.current()
                .children()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .map(ProcessHandle::pid)
                .collect(Collectors.toSet());
    }

    /**
     * After the fault, the world equals a world without the law. The engine and the other laws
     * stay.
     */
    @ParameterizedTest
    @CsvSource({
        "segfault, LAW_CRASHED, ended its process: SIGSEGV",
        "abort, LAW_CRASHED, ended its process: SIGABRT",
        "exit, LAW_CRASHED, ended its process: exit code 3",
        "const_write, LAW_CRASHED, ended its process: SIGSEGV",
        "far_write, LAW_CRASHED, ended its process: SIG",
        "memory, LAW_CRASHED, ended its process: SIG",
        "fork, LAW_CRASHED, 'made the system call clone, which its sandbox does not permit'",
        "exec, LAW_CRASHED, 'made the system call execve,'",
        "quiet_thread, LAW_CRASHED, 'made the system call '",
        "kill, LAW_CRASHED, 'made the system call tgkill,'",
        "loop, LAW_TIMED_OUT, no answer within 3",
        "sleep, LAW_TIMED_OUT, no answer within 3",
    })
    void aFaultCostsTheLawOnly(String kind, Status status, String how) {
        Set<Long> ending = hosts(); // of tests before
        try (HostedFixture hosted = apart(HOSTILE);
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion");
            expected.load("newton_motion");
            hosted.world.adapter.laws().load(0, "hostile_" + kind, Map.of());
            int id = hosted.world.adapter.laws().latest().orElseThrow().getKey();
            assertThat(hosted.world.adapter.laws().isApart(id)).isTrue();
            int wind = expected.adapter.laws().load(0, "wind", Map.of());
            hosted.world.run(BAD_FRAME - 1);
            expected.run(BAD_FRAME - 1);
            Set<Long> before = hosts();
            before.removeAll(ending);
            expected.adapter.laws().unload(BAD_FRAME, wind);
            for (int frame = BAD_FRAME; frame <= FRAMES; frame++) {
                expected.run(1);
                hosted.world.run(1);
                assertThat(hosted.world.bytes()).as("frame " + frame).isEqualTo(expected.bytes());
            }
            Set<Long> after = hosts();
            after.removeAll(ending);
            assertThat(before)
                    .as("no host was started; that of the trial may end late")
                    .containsAll(after);
            assertThat(hosted.world.adapter.profile().redoneFrames()).isOne();
            assertThat(hosted.world.events("fault")).hasSize(1);
            WorldEvent fault = hosted.world.events("fault").getFirst();
            assertThat(fault.frame()).isEqualTo(BAD_FRAME);
            assertThat(fault.fields())
                    .containsEntry("library", "hostile")
                    .containsEntry("law", "hostile")
                    .containsEntry("status", status.name());
            assertThat(fault.fields().get("message")).asString().contains("law hostile: " + how);
        }
    }

    @Test
    void aLibraryThatEndsItsTrialIsRefused() {
        try (HostedFixture hosted = apart(HOSTILE)) {
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(
                            () -> hosted.world.engine.prepare("hostile_segfault_in_constructor"))
                    .withMessageContaining("ended its process: SIGSEGV")
                    .extracting(PhysicsException::status)
                    .isEqualTo(Status.LIBRARY_LOAD_FAILED);
        }
    }

    /** 1,000 steps; barnes_hut_gravitation calls parallel_for. */
    @Test
    void shippedLawsHaveTheBitsOfTheEngine() {
        String[] laws = {
            "barnes_hut_gravitation", "sphere_contact", "velocity_verlet", "angular_motion"
        };
        try (HostedFixture hosted = apart((file, library) -> ApartRule.Isolation.APART);
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load(laws).run(250); // of four steps
            expected.load(laws).run(250);
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.bytes()).isEqualTo(expected.bytes());
            assertThat(hosted.world.adapter.stateHash()).isEqualTo(expected.adapter.stateHash());
        }
    }

    /** A lost engine's process is replaced with its sandboxes, in the middle of the run. */
    @Test
    void aNewProcessOfTheEngineRunsTheSameLawsApart() {
        try (HostedFixture hosted = apart((file, library) -> ApartRule.Isolation.APART);
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "wind").run(5);
            Set<Long> before = hosts();
            ProcessHandle.current()
                    .children()
                    .filter(child -> before.contains(child.pid()))
                    .forEach(ProcessHandle::destroyForcibly);
            hosted.world.run(5);
            expected.load("newton_motion", "wind").run(10);
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.bytes()).isEqualTo(expected.bytes());
        }
    }

    @Test
    void aLawInPythonCannotRunApart() {
        byte[] law = "import vesper\n@vesper.law\ndef f(x): pass\n".getBytes();
        try (HostedFixture hosted = apart((file, library) -> ApartRule.Isolation.APART)) {
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> hosted.world.engine.prepare(law))
                    .withMessageContaining("a law in Python cannot run apart");
        }
    }
}
