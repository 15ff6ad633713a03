// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;

import reve.pe.EngineContract;
import reve.pe.EngineFixture;
import reve.pe.NativeFiles;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.Prototype;
import reve.pe.SpringOrbit;
import reve.pe.Status;
import reve.pe.posix.SharedMemory;
import reve.pe.posix.SharedPart;
import reve.pe.vesper.VesperConfig;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.time.Duration;
import java.util.HashMap;
import java.util.List;
import java.util.Map;

class HostedEngineNativeTest extends EngineContract {
    @Override
    protected EngineFixture.Home home() {
        return new Hosted();
    }

    /** Engines in processes of their own, and shared memory. */
    private static final class Hosted implements EngineFixture.Home {
        private final Hosts hosts = new Hosts(NativeFiles.program("vesper-host"), 0);
        private final Map<Long, SharedMemory> memories = new HashMap<>();

        @Override
        public PhysicsEngine engine(VesperConfig config, Prototype prototype) {
            return new HostedEngine(hosts, Duration.ofSeconds(10), config, prototype, this::part);
        }

        private SharedPart part(MemorySegment segment) {
            SharedMemory memory = memories.get(segment.address());
            if (memory == null) {
                throw new IllegalArgumentException("memory that is not shared");
            }
            return new SharedPart(memory.descriptor(), 0);
        }

        @Override
        public MemorySegment allocate(long bytes) {
            SharedMemory memory = new SharedMemory("test", bytes);
            memories.put(memory.segment().address(), memory);
            return memory.segment();
        }

        @Override
        public void release(MemorySegment memory) {
            memories.remove(memory.address()).close();
        }

        @Override
        public void close() {
            hosts.close();
            memories.values().forEach(SharedMemory::close);
        }
    }

    /** Returns the processes that run the host of this process's engines, without the warm one. */
    private static List<ProcessHandle> hostsWith(String library) {
        return ProcessHandle.current()
                .children()
                .filter(child -> child.info().command().orElse("").endsWith("vesper-host"))
                .filter(child -> maps(child).contains(library))
                .toList();
    }

    private static String maps(ProcessHandle process) {
        try {
            return java.nio.file.Files.readString(
                    java.nio.file.Path.of("/proc/" + process.pid() + "/maps"));
        } catch (java.io.IOException ended) {
            return "";
        }
    }

    @Test
    void memoryThatIsNotSharedIsRefused() {
        try (Arena arena = Arena.ofShared();
                EngineFixture orbit = new EngineFixture(home())) {
            assertThatIllegalArgumentException()
                    .isThrownBy(
                            () ->
                                    orbit.engine
                                            .propertyProvider()
                                            .addPhysicalProperty("mass", arena.allocate(16), 2))
                    .withMessage("memory that is not shared");
        }
    }

    /** The state of the engine is that before the loss: its clock, and what laws remember. */
    @Test
    void aHostThatIsKilledBetweenTwoFramesIsReplacedWithoutALoss() {
        try (EngineFixture orbit =
                        new EngineFixture(home())
                                .springOrbit()
                                .load(SpringOrbit.LAWS)
                                .load("counts_years");
                EngineFixture undisturbed =
                        new EngineFixture(home())
                                .springOrbit()
                                .load(SpringOrbit.LAWS)
                                .load("counts_years")) {
            for (int frame = 0; frame < 10; frame++) {
                if (frame % 3 == 1) {
                    // Listed once: a host that ends no longer shows its laws.
                    List<ProcessHandle> doomed = hostsWith("law");
                    doomed.forEach(ProcessHandle::destroyForcibly);
                    doomed.forEach(host -> host.onExit().join());
                }
                orbit.engine.advance(SpringOrbit.DT, 4);
                undisturbed.engine.advance(SpringOrbit.DT, 4);
                assertThat(orbit.engine.stateHash()).isEqualTo(undisturbed.engine.stateHash());
                assertThat(orbit.engine.saveState()).isEqualTo(undisturbed.engine.saveState());
            }
            assertThat(orbit.engine.stepCount()).isEqualTo(40);
            assertThat(orbit.engine.laws())
                    .extracting(PhysicsLaw::calls)
                    .isEqualTo(undisturbed.engine.laws().stream().map(PhysicsLaw::calls).toList());
        }
    }

    @Test
    void aHostThatIsKilledInAFrameIsNoFaultOfALaw() throws Exception {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            orbit.engine.advance(SpringOrbit.DT, 1);
            int steps = 100_000_000; // longer than the killer waits
            Thread killer =
                    Thread.ofPlatform()
                            .start(
                                    () -> {
                                        sleep(300);
                                        hostsWith("law").forEach(ProcessHandle::destroyForcibly);
                                    });
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> orbit.engine.advance(SpringOrbit.DT, steps))
                    .satisfies(
                            lost ->
                                    assertThat(lost.status())
                                            .isIn(Status.ENGINE_LOST, Status.LAW_CRASHED));
            killer.join();
            assertThat(orbit.engine.stepCount()).isOne();
        }
    }

    private static void sleep(long millis) {
        try {
            Thread.sleep(millis);
        } catch (InterruptedException e) {
            throw new IllegalStateException(e);
        }
    }
}
