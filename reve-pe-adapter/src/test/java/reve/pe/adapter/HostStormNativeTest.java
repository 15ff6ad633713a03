// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

import java.io.IOException;
import java.util.List;
import java.util.Random;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReference;
import java.util.concurrent.locks.LockSupport;

/** Engine processes that another program kills, or stops and continues, again and again. */
@Tag("slow")
@Timeout(value = 30, unit = TimeUnit.MINUTES, threadMode = Timeout.ThreadMode.SEPARATE_THREAD)
class HostStormNativeTest {
    /** Number of times at which the process is killed. The fault model requires 10,000. */
    private static final int KILLS = Integer.getInteger("reve.test.host.kills", 25);

    /** Number of times at which the process is stopped. The fault model requires 10,000. */
    private static final int STOPS = Integer.getInteger("reve.test.host.stops", 150);

    /**
     * Maximum time from the end of a frame to a kill. Therefore a kill can occur in any part of a
     * frame.
     */
    private static final long MOST_DELAY_NANOS = 3_000_000;

    /** Stops the process $1 for about a millisecond, $2 times. */
    private static final String STOPPER =
            "for i in $(seq $2); do"
                    + " kill -STOP $1; sleep 0.00$((RANDOM % 3 + 1));"
                    + " kill -CONT $1; sleep 0.00$((RANDOM % 3 + 1)); done";

    @Test
    void noKillTakesALawTearsAFrameOrBlocksTheWorld() throws Exception {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.hosts.keepReady(1);
            hosted.world.load("newton_motion", "wind", "counts_years");
            expected.load("newton_motion", "wind", "counts_years");
            Random random = new Random(1902);
            AtomicInteger frames = new AtomicInteger();
            AtomicReference<Throwable> failure = new AtomicReference<>();
            Thread killer =
                    Thread.ofPlatform()
                            .daemon()
                            .uncaughtExceptionHandler((thread, thrown) -> failure.set(thrown))
                            .start(
                                    () -> {
                                        for (int kill = 0; kill < KILLS; kill++) {
                                            int made = frames.get();
                                            while (frames.get() <= made + random.nextInt(20)) {
                                                LockSupport.parkNanos(100_000);
                                            }
                                            LockSupport.parkNanos(
                                                    random.nextLong(MOST_DELAY_NANOS));
                                            hosts().forEach(ProcessHandle::destroyForcibly);
                                        }
                                    });
            for (boolean last = false; !last; ) {
                last = !killer.isAlive(); // one frame more after the last kill
                hosted.world.run(1);
                expected.run(1);
                frames.incrementAndGet();
                assertThat(hosted.world.adapter.stateHash())
                        .as("after frame " + frames)
                        .isEqualTo(expected.adapter.stateHash());
            }
            assertThat(failure.get()).isNull();
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.adapter.laws().loaded()).hasSize(3);
            assertThat(hosted.world.bytes()).isEqualTo(expected.bytes());
        }
    }

    @Test
    void noStopMakesAFrameFailOrWaitForEver() throws Exception {
        try (HostedFixture hosted = new HostedFixture();
                AdapterFixture expected = HostedFixture.inProcess()) {
            hosted.world.load("newton_motion", "wind").run(1);
            expected.load("newton_motion", "wind").run(1);
            List<ProcessHandle> stopped = hosts();
            Process[] stoppers = new Process[stopped.size()];
            for (int i = 0; i < stoppers.length; i++) {
                stoppers[i] = stopper(stopped.get(i).pid());
            }
            int frames = 1;
            for (boolean last = false; !last; frames++) {
                last = List.of(stoppers).stream().noneMatch(Process::isAlive);
                hosted.world.run(1);
            }
            for (Process stopper : stoppers) {
                assertThat(stopper.waitFor()).isZero();
            }
            expected.run(frames - 1);
            assertThat(hosted.world.events("fault")).isEmpty();
            assertThat(hosted.world.adapter.profile().redoneFrames()).isZero();
            assertThat(hosts()).as("the same process").containsAll(stopped);
            assertThat(hosted.world.bytes()).isEqualTo(expected.bytes());
        }
    }

    private static Process stopper(long pid) throws IOException {
        return new ProcessBuilder(
                        "bash", "-c", STOPPER, "bash", Long.toString(pid), Integer.toString(STOPS))
                .inheritIO()
                .start();
    }

    private static List<ProcessHandle> hosts() {
        return ProcessHandle.current()
                .children()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .toList();
    }
}
