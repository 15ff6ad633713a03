// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import reve.pe.PhysicsException;

import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Random;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;

/** Engine processes that are killed while a law computes on an OpenCL device. */
@Tag("slow")
@Timeout(value = 30, unit = TimeUnit.MINUTES, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class DeviceLossNativeTest {
    /** Number of times at which the process is killed. The fault model requires 50. */
    private static final int KILLS = Integer.getInteger("reve.test.device.kills", 2);

    private static final Path DRIVERS = Path.of("/etc/OpenCL/vendors");
    private static final long MOST_DELAY_NANOS = 3_000_000;
    private static final int FRAMES_BETWEEN = 3;

    @Test
    void theNextProcessUsesTheDeviceAgainAndNoFrameDiffers() throws Exception {
        try (HostedFixture undisturbed = new HostedFixture()) {
            if (Files.notExists(DRIVERS)) {
                assertThatExceptionOfType(PhysicsException.class)
                        .isThrownBy(() -> undisturbed.world.load("opencl_gravitation"))
                        .withMessageContaining("OpenCL");
                return;
            }
            undisturbed.world.load("newton_motion", "opencl_gravitation").run(1);
            killAgainAndAgain(undisturbed, hosts());
        }
    }

    private static void killAgainAndAgain(HostedFixture undisturbed, List<Long> spared)
            throws InterruptedException {
        try (HostedFixture hosted = new HostedFixture()) {
            hosted.world.load("newton_motion", "opencl_gravitation").run(1);
            List<Long> first = others(spared);
            Random random = new Random(1912);
            for (int kill = 0; kill < KILLS; kill++) {
                Thread killer =
                        Thread.ofPlatform()
                                .daemon()
                                .start(
                                        () -> {
                                            LockSupport.parkNanos(
                                                    random.nextLong(MOST_DELAY_NANOS));
                                            others(spared).forEach(DeviceLossNativeTest::kill);
                                        });
                for (int frame = 0; frame < FRAMES_BETWEEN; frame++) {
                    hosted.world.run(1);
                    undisturbed.world.run(1);
                    assertThat(hosted.world.adapter.stateHash())
                            .as("after kill " + kill)
                            .isEqualTo(undisturbed.world.adapter.stateHash());
                }
                killer.join();
            }
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.adapter.laws().libraries()).hasSize(2);
            assertThat(hosts())
                    .as("the processes of the beginning")
                    .doesNotContainAnyElementsOf(first);
        }
    }

    private static List<Long> others(List<Long> spared) {
        return hosts().stream().filter(pid -> !spared.contains(pid)).toList();
    }

    private static List<Long> hosts() {
        return ProcessHandle.current()
                .children()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .map(ProcessHandle::pid)
                .toList();
    }

    private static void kill(long pid) {
        ProcessHandle.of(pid).ifPresent(ProcessHandle::destroyForcibly);
    }
}
