// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.pe.EngineContract;
import reve.pe.EngineFixture;
import reve.pe.NativeFiles;
import reve.pe.PhysicsEngine;
import reve.pe.PhysicsException;
import reve.pe.PhysicsLaw;
import reve.pe.PreparedLibrary;
import reve.pe.Prototype;
import reve.pe.SpringOrbit;
import reve.pe.Status;
import reve.pe.posix.SharedMemory;
import reve.pe.posix.SharedPart;
import reve.pe.vesper.VesperConfig;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Random;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReference;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Supplier;

class HostedEngineNativeTest extends EngineContract {
    @Override
    protected EngineFixture.Home home() {
        return new Hosted(new Hosts(NativeFiles.program("vesper-host"), 0));
    }

    /** A kind of engine that runs in a process of its own, with shared memory. */
    private static final class Hosted implements EngineFixture.Home {
        private final Hosts hosts;
        private final Duration frameLimit;
        private final Map<Long, SharedMemory> memories = new HashMap<>();

        Hosted(Hosts hosts) {
            this(hosts, Duration.ofSeconds(10));
        }

        Hosted(Hosts hosts, Duration frameLimit) {
            this.hosts = hosts;
            this.frameLimit = frameLimit;
        }

        @Override
        public PhysicsEngine engine(VesperConfig config, Prototype prototype) {
            return new HostedEngine(
                    hosts, frameLimit, config, prototype, ApartRule.NEVER, this::part);
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

    /**
     * The engine has the state that it had before the loss. This includes its clock and the memory
     * of laws.
     */
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
                    killHosts();
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

    /** Therefore a rewind or a change of a parameter does not depend on another process. */
    @Test
    void bytesThatHavePassedATrialAreNotTestedAgain() {
        Path program = NativeFiles.program("vesper-host");
        int[] starts = {0};
        try (Hosts hosts =
                        new Hosts(
                                () -> {
                                    starts[0]++;
                                    return new HostProcess(program, 0);
                                },
                                start -> {});
                EngineFixture orbit =
                        new EngineFixture(new Hosted(hosts)).springOrbit().load(SpringOrbit.LAWS)) {
            int before = starts[0];
            assertThat(before).isEqualTo(1 + SpringOrbit.LAWS.length);
            for (String law : SpringOrbit.LAWS) {
                try (PreparedLibrary again = orbit.engine.prepare(law)) {
                    assertThat(again.name()).isEqualTo(law);
                }
            }
            assertThat(starts[0]).isEqualTo(before);
        }
    }

    @Test
    void aTrialThatAnotherProgramKillsIsMadeAgain() {
        Path program = NativeFiles.program("vesper-host");
        int[] starts = {0};
        try (Hosts hosts =
                        new Hosts(
                                () -> {
                                    var host = new HostProcess(program, 0);
                                    if (++starts[0] == 2 || starts[0] == 3) {
                                        killHosts();
                                    }
                                    return host;
                                },
                                start -> {});
                EngineFixture orbit = new EngineFixture(new Hosted(hosts)).springOrbit()) {
            try (PreparedLibrary drag = orbit.engine.prepare("drag")) {
                assertThat(drag.name()).isEqualTo("drag");
            }
            assertThat(starts[0]).isEqualTo(4);
        }
    }

    /** Therefore a server that ends does not wait for a library that never returns. */
    @Test
    void aTrialEndsIfItsThreadIsInterrupted() throws Exception {
        Path program = NativeFiles.program("vesper-host");
        var starts = new AtomicInteger();
        var refusal = new AtomicReference<Throwable>();
        try (Hosts hosts =
                        new Hosts(
                                () -> {
                                    starts.incrementAndGet();
                                    return new HostProcess(program, 0);
                                },
                                start -> {});
                EngineFixture orbit = new EngineFixture(new Hosted(hosts)).springOrbit()) {
            Thread folder =
                    Thread.ofPlatform()
                            .start(
                                    () -> {
                                        try {
                                            orbit.engine.prepare("hostile_loop_in_create").close();
                                        } catch (PhysicsException refused) {
                                            refusal.set(refused);
                                        }
                                    });
            while (starts.get() < 2) {
                Thread.onSpinWait();
            }
            folder.interrupt();
            folder.join();
            assertThat(refusal.get()).hasMessageContaining("not tested to the end");
            assertThat(starts).hasValue(2);
        }
    }

    @Test
    void aHostThatIsKilledInAFrameIsNoFaultOfALaw() throws Exception {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            orbit.engine.advance(SpringOrbit.DT, 1);
            int steps = 100_000_000; // longer than the killer waits
            var ended = new AtomicBoolean();
            Thread killer =
                    Thread.ofPlatform()
                            .start(
                                    () -> {
                                        while (!ended.get()) { // the frame may begin late
                                            sleep(300);
                                            hostsWith("law")
                                                    .forEach(ProcessHandle::destroyForcibly);
                                        }
                                    });
            try {
                assertThatExceptionOfType(PhysicsException.class)
                        .isThrownBy(() -> orbit.engine.advance(SpringOrbit.DT, steps))
                        .satisfies(lost -> assertThat(lost.status()).isEqualTo(Status.ENGINE_LOST));
            } finally {
                ended.set(true);
                killer.join();
            }
            assertThat(orbit.engine.stepCount()).isOne();
        }
    }

    /** A state that is kept after rows moved includes these moves. */
    @ParameterizedTest
    @ValueSource(strings = {"load", "unload", "save"})
    void aNewHostDoesNotRepeatMovesOfRowsThatAreInItsState(String next) {
        try (EngineFixture hosted = new EngineFixture(home()).springOrbit().load("counts_years");
                EngineFixture undisturbed =
                        new EngineFixture(new EngineFixture.InProcess())
                                .springOrbit()
                                .load("counts_years")) {
            for (EngineFixture orbit : List.of(hosted, undisturbed)) {
                int wind = orbit.engine.loadPhysicsLaw("wind", Map.of());
                orbit.engine.advance(SpringOrbit.DT, 3);
                orbit.engine.moveRows("body", new long[] {1, 0});
                switch (next) {
                    case "load" -> orbit.engine.loadPhysicsLaw("greets", Map.of());
                    case "unload" -> orbit.engine.unloadPhysicsLaw(wind);
                    default -> orbit.engine.saveState();
                }
            }
            killHosts();
            assertThat(hosted.engine.saveState()).isEqualTo(undisturbed.engine.saveState());
            hosted.engine.advance(SpringOrbit.DT, 1);
            undisturbed.engine.advance(SpringOrbit.DT, 1);
            assertThat(hosted.get("velocity")).isEqualTo(undisturbed.get("velocity"));
        }
    }

    /** The library is loaded when the host is lost, but no kept state includes its memory. */
    @Test
    void aHostThatIsLostAfterALoadKnowsNothingOfTheLibrary() {
        boolean[] doomed = {false};
        Path program = NativeFiles.program("vesper-host");
        Hosts hosts =
                new Hosts(
                        () ->
                                new HostProcess(program, 0) {
                                    @Override
                                    Mailbox begin(Request number) {
                                        if (number == Request.SAVE_STATE && doomed[0]) {
                                            doomed[0] = false;
                                            killHosts();
                                        }
                                        return super.begin(number);
                                    }
                                },
                        Runnable::run);
        try (EngineFixture orbit = new EngineFixture(new Hosted(hosts)).springOrbit()) {
            orbit.engine.advance(SpringOrbit.DT, 1);
            doomed[0] = true;
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> orbit.engine.loadPhysicsLaw("counts_years", Map.of()))
                    .withMessageContaining("while it was loaded");
            orbit.engine.loadPhysicsLaw("counts_years", Map.of());
            orbit.engine.advance(SpringOrbit.DT, 1);
            assertThat(orbit.engine.laws())
                    .extracting(PhysicsLaw::library)
                    .endsWith("counts_years")
                    .doesNotHaveDuplicates();
        }
    }

    /** Number of sets of references. The fault model requires 100,000. */
    private static final int REFERENCES = Integer.getInteger("reve.test.references", 1_000);

    /**
     * A spring refers to two bodies. There are two bodies, so only the numbers 0 and 1 refer to
     * bodies.
     */
    @Test
    void everyReferenceOutOfRangeIsRefusedByPropertyAndRowAndEveryOtherIsAccepted() {
        int[] numbers = {0, 1, 0, 1, 0, 1, 2, -1, 3, Integer.MAX_VALUE, Integer.MIN_VALUE};
        Random random = new Random(1909);
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit().load(SpringOrbit.LAWS)) {
            MemorySegment endpoints = orbit.arrays.get("endpoints");
            int refused = 0;
            for (int set = 0; set < REFERENCES; set++) {
                boolean bad = false;
                for (int end = 0; end < 2; end++) {
                    int number =
                            random.nextInt(8) == 0
                                    ? random.nextInt()
                                    : numbers[random.nextInt(numbers.length)];
                    bad |= number < 0 || number > 1;
                    endpoints.setAtIndex(ValueLayout.JAVA_INT, end, number);
                }
                try {
                    orbit.engine.propertyProvider().touch("endpoints");
                    orbit.engine.advance(1e-9, 1);
                    assertThat(bad).as("set " + set + " was accepted").isFalse();
                } catch (PhysicsException failure) {
                    refused++;
                    assertThat(bad).as("set " + set + ": " + failure.getMessage()).isTrue();
                    assertThat(failure.status()).isEqualTo(Status.INVALID_ARGUMENT);
                    assertThat(failure.property()).isEqualTo("endpoints");
                    assertThat(failure.row()).hasValue(0);
                }
            }
            assertThat(refused).isBetween(REFERENCES / 3, REFERENCES);
        }
    }

    /** A virtual thread would occupy a carrier, as HostProcess explains. */
    @Test
    void theOutputOfLawsIsReadByAPlatformThread() {
        try (EngineFixture orbit = new EngineFixture(home()).springOrbit()) {
            orbit.engine.advance(SpringOrbit.DT, 1);
            // getAllStackTraces has no virtual threads
            assertThat(Thread.getAllStackTraces().keySet())
                    .extracting(Thread::getName)
                    .contains("output of laws");
        }
    }

    /** The moves need three requests, and only the last move changes something. */
    @Test
    void manyRowsMoveAsInTheSameProcess() {
        long[] moves = new long[80_000];
        Arrays.fill(moves, 2); // no such row
        moves[moves.length - 2] = 1;
        moves[moves.length - 1] = 0;
        try (EngineFixture hosted = new EngineFixture(home()).springOrbit().load("counts_years");
                EngineFixture inProcess =
                        new EngineFixture(new EngineFixture.InProcess())
                                .springOrbit()
                                .load("counts_years")) {
            for (EngineFixture orbit : List.of(hosted, inProcess)) {
                orbit.engine.advance(SpringOrbit.DT, 3);
                byte[] before = orbit.engine.saveState();
                orbit.engine.moveRows("body", moves);
                assertThat(orbit.engine.saveState()).isNotEqualTo(before);
            }
            assertThat(hosted.engine.saveState()).isEqualTo(inProcess.engine.saveState());
        }
    }

    /** The program of such a process may lie on a disk that hangs. */
    @Test
    void aProcessThatNeverAnswersDelaysOneFrameInTenSeconds(@TempDir Path folder) throws Exception {
        Path silent = Files.writeString(folder.resolve("silent"), "#!/bin/sh\nexec sleep 1000\n");
        assertThat(silent.toFile().setExecutable(true)).isTrue();
        Path[] program = {NativeFiles.program("vesper-host")};
        var starts = new AtomicInteger();
        Supplier<HostProcess> starting =
                () -> {
                    starts.incrementAndGet();
                    return new HostProcess(program[0], 0);
                };
        try (Hosts hosts = new Hosts(starting, start -> {});
                EngineFixture orbit =
                        new EngineFixture(new Hosted(hosts, Duration.ofMillis(50))).springOrbit()) {
            killHosts();
            program[0] = silent;
            assertThat(failedAdvance(orbit)).isBetween(0.9, 20.0);
            assertThat(failedAdvance(orbit))
                    .as("the next one is tried at once")
                    .isBetween(0.9, 20.0);
            int before = starts.get();
            long began = System.nanoTime();
            double[] seconds = new double[10];
            Arrays.setAll(seconds, frame -> failedAdvance(orbit));
            Arrays.sort(seconds);
            assertThat(seconds[0]).as("each frame fails").isPositive();
            assertThat(seconds[5]).as("the median does not wait for a start").isLessThan(0.9);
            assertThat(starts.get() - before)
                    .as("one start in ten seconds, and these frames last only milliseconds")
                    .isLessThanOrEqualTo((int) ((System.nanoTime() - began) / 10_000_000_000L));
            program[0] = NativeFiles.program("vesper-host");
            long end = System.nanoTime() + TimeUnit.MINUTES.toNanos(10);
            while (orbit.engine.stepCount() == 0 && System.nanoTime() < end) {
                failedAdvance(orbit);
                LockSupport.parkNanos(TimeUnit.MILLISECONDS.toNanos(100));
            }
            assertThat(orbit.engine.stepCount()).isPositive();
        }
    }

    /** Advances, and returns how long this took until it failed; 0 if it did not fail [s]. */
    private static double failedAdvance(EngineFixture orbit) {
        long began = System.nanoTime();
        try {
            orbit.engine.advance(SpringOrbit.DT, 1);
            return 0;
        } catch (IllegalStateException failed) {
            assertThat(failed).hasMessageContaining("another one is started");
            return (System.nanoTime() - began) * 1e-9;
        }
    }

    /** If no thread can be started, there is no warm process. Later there may be one. */
    @Test
    void aSystemWithoutFurtherThreadsCostsOnlyTheWarmProcess() {
        Path program = NativeFiles.program("vesper-host");
        List<Runnable> later = new ArrayList<>();
        boolean[] full = {true};
        try (Hosts hosts =
                        new Hosts(
                                () -> new HostProcess(program, 0),
                                start -> {
                                    if (full[0]) {
                                        throw new OutOfMemoryError(NO_THREAD);
                                    }
                                    later.add(start);
                                });
                EngineFixture orbit = new EngineFixture(new Hosted(hosts)).springOrbit()) {
            full[0] = false;
            killAndAdvance(orbit);
            assertThat(later).hasSize(1); // this one never starts
            killAndAdvance(orbit);
            assertThat(later).hasSize(2);
            assertThat(orbit.engine.stepCount()).isEqualTo(2);
        }
    }

    @Test
    void aWarmProcessThatCouldNotStartIsReplacedByAnother() {
        Path program = NativeFiles.program("vesper-host");
        int[] starts = {0};
        try (Hosts hosts =
                        new Hosts(
                                () -> {
                                    if (++starts[0] == 2) {
                                        throw new OutOfMemoryError(NO_THREAD);
                                    }
                                    return new HostProcess(program, 0);
                                },
                                start -> {
                                    try {
                                        start.run();
                                    } catch (OutOfMemoryError endsTheThread) {
                                        // It ends nothing else.
                                    }
                                });
                EngineFixture orbit = new EngineFixture(new Hosted(hosts)).springOrbit()) {
            killAndAdvance(orbit);
            assertThat(orbit.engine.stepCount()).isOne();
        }
    }

    /**
     * The ready host already has the libraries. Therefore it only unloads libraries that were
     * removed, and receives the columns and the state.
     */
    @Test
    void aHostThatIsReadyWithTheLibrariesReplacesALostOne() {
        List<Request> requests = new ArrayList<>();
        Hosts hosts = recording(requests);
        hosts.keepReady(1);
        try (EngineFixture orbit =
                        new EngineFixture(new Hosted(hosts))
                                .springOrbit()
                                .load(SpringOrbit.LAWS)
                                .load("counts_years");
                EngineFixture undisturbed =
                        new EngineFixture(home())
                                .springOrbit()
                                .load(SpringOrbit.LAWS)
                                .load("counts_years")) {
            int crashing = orbit.engine.loadPhysicsLaw("hostile_segfault", Map.of());
            int pushing = undisturbed.engine.loadPhysicsLaw("wind", Map.of());
            for (int frame = 0; frame < 12; frame++) { // 48 steps
                orbit.engine.advance(SpringOrbit.DT, 4);
                undisturbed.engine.advance(SpringOrbit.DT, 4);
            }
            Map<String, byte[]> before = bytes(orbit);
            assertThatExceptionOfType(PhysicsException.class)
                    .isThrownBy(() -> orbit.engine.advance(SpringOrbit.DT, 4))
                    .withMessageContaining("SIGSEGV");
            before.forEach(
                    (name, bytes) -> orbit.arrays.get(name).copyFrom(MemorySegment.ofArray(bytes)));
            orbit.engine.unloadPhysicsLaw(crashing);
            undisturbed.engine.unloadPhysicsLaw(pushing);
            requests.clear();
            orbit.engine.advance(SpringOrbit.DT, 4);
            assertThat(requests)
                    .containsExactly(
                            Request.UNLOAD,
                            Request.BIND_ALL,
                            Request.STATE_MEMORY,
                            Request.LOAD_STATE,
                            Request.ADVANCE);
            undisturbed.engine.advance(SpringOrbit.DT, 4);
            assertThat(orbit.engine.stateHash()).isEqualTo(undisturbed.engine.stateHash());
            assertThat(orbit.engine.saveState()).isEqualTo(undisturbed.engine.saveState());
            assertThat(orbit.engine.laws())
                    .extracting(PhysicsLaw::library)
                    .doesNotContain("hostile")
                    .endsWith("counts_years");
        }
    }

    /** A thread that a library started in the ready host could write to the world's columns. */
    @Test
    void aReadyHostInWhichAnUnloadedLibraryLeftAThreadIsNotUsed() {
        List<Request> requests = new ArrayList<>();
        Hosts hosts = recording(requests);
        hosts.keepReady(1);
        try (EngineFixture orbit =
                new EngineFixture(new Hosted(hosts)).springOrbit().load("counts_years")) {
            int leaving = orbit.engine.loadPhysicsLaw("hostile_quiet_thread_in_create", Map.of());
            List<ProcessHandle> inUse = hostsWith("counts_years");
            for (int frame = 0; frame < 11; frame++) {
                orbit.engine.advance(SpringOrbit.DT, 1);
            }
            assertThat(hostsWith("counts_years")).hasSize(inUse.size() + 1);
            kill(inUse);
            orbit.engine.unloadPhysicsLaw(leaving);
            requests.clear();
            orbit.engine.advance(SpringOrbit.DT, 1);
            assertThat(requests)
                    .startsWith(Request.UNLOAD, Request.CREATE)
                    .endsWith(Request.ADVANCE);
            assertThat(orbit.engine.stepCount()).isEqualTo(12);
        }
    }

    @Test
    void onlyAsManyEnginesAsPermittedKeepAHostReady() {
        for (int permitted = 0; permitted <= 1; permitted++) {
            List<Request> requests = new ArrayList<>();
            Hosts hosts = recording(requests);
            hosts.keepReady(permitted);
            try (EngineFixture orbit =
                    new EngineFixture(new Hosted(hosts)).springOrbit().load("counts_years")) {
                requests.clear();
                for (int frame = 0; frame < 30; frame++) {
                    orbit.engine.advance(SpringOrbit.DT, 1);
                }
                assertThat(requests.stream().filter(Request.CREATE::equals)).hasSize(permitted);
            }
        }
    }

    /** Starts processes on the calling thread, and lists the requests to them. */
    private static Hosts recording(List<Request> requests) {
        Path program = NativeFiles.program("vesper-host");
        return new Hosts(
                () ->
                        new HostProcess(program, 0) {
                            @Override
                            Mailbox begin(Request number) {
                                requests.add(number);
                                return super.begin(number);
                            }
                        },
                Runnable::run);
    }

    private static Map<String, byte[]> bytes(EngineFixture orbit) {
        Map<String, byte[]> bytes = new HashMap<>();
        orbit.arrays.forEach(
                (name, array) ->
                        bytes.put(name, array.toArray(java.lang.foreign.ValueLayout.JAVA_BYTE)));
        return bytes;
    }

    private static final String NO_THREAD = "unable to create native thread";

    private static void killHosts() {
        kill(hostsWith("vesper-host"));
    }

    private static void kill(List<ProcessHandle> doomed) {
        doomed.forEach(ProcessHandle::destroyForcibly);
        doomed.forEach(host -> host.onExit().join());
    }

    private static void killAndAdvance(EngineFixture orbit) {
        killHosts();
        orbit.engine.advance(SpringOrbit.DT, 1);
    }

    private static void sleep(long millis) {
        try {
            Thread.sleep(millis);
        } catch (InterruptedException e) {
            throw new IllegalStateException(e);
        }
    }
}
