// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_INT_UNALIGNED;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.pe.posix.ProcessGroup;
import reve.pe.posix.SharedMemory;
import reve.pe.posix.SharedWord;
import reve.pe.vesper.VesperLog;

import java.io.IOException;
import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.concurrent.TimeUnit;
import java.util.function.LongPredicate;

/**
 * A process {@code vesper-host}, which runs an engine, and the shared memory for requests and
 * replies. {@code vesper-native/host/control.hpp} defines the layout of this memory. Any thread may
 * call this object, but only one call at a time is permitted.
 */
class HostProcess implements AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("laws");
    private static final long CONTROL_BYTES = 1 << 20;
    private static final long REQUEST = 64;
    private static final long REPLY = 128;
    private static final long RUNNING = 192;
    private static final int MAX_THREADS = 256;
    private static final long WROTE = 2240;
    private static final int WROTE_BYTES = 56;
    private static final long WROTE_OFFSET = 2296;
    private static final long LOG_USED = 2304;
    private static final long LOG_DROPPED = 2308;
    private static final long LOG_LINES = 2312;
    private static final long MAILBOX = 1 << 16;
    private static final System.Logger.Level[] LEVELS = {
        System.Logger.Level.DEBUG,
        System.Logger.Level.INFO,
        System.Logger.Level.WARNING,
        System.Logger.Level.ERROR
    };

    /** Interval at which a waiting client checks whether the host still works [ns]. */
    private static final long LOOK_NANOS = 1_000_000;

    /**
     * Interval at which a waiting client checks whether the host still lives [ns]. It is shorter
     * than {@link #LOOK_NANOS}, because this check is cheap, and a crash must cost less time than a
     * frame.
     */
    private static final long ALIVE_NANOS = LOOK_NANOS / 4;

    /**
     * Maximum idle time that counts for one interval [ns]. A longer interval means that this
     * process did not run, and that the host perhaps did not run either.
     */
    private static final long MOST_LOOK_NANOS = 10 * LOOK_NANOS;

    /**
     * Maximum busy-wait for a reply in a world that runs as fast as it can, without a clock [ns].
     * The value is 0 on a machine with one processor, where the wait would take processor time from
     * the host.
     */
    private static final long AWAKE_NANOS =
            Runtime.getRuntime().availableProcessors() > 1 ? 50_000 : 0;

    /**
     * Pause between two calls below which a world counts as running as fast as it can [ns]. The
     * pauses are longer in a world that waits for a clock.
     */
    private static final long QUICK_NANOS = 5_000_000;

    private static final Map<Integer, String> SIGNALS =
            Map.of(
                    4, "SIGILL", 5, "SIGTRAP", 6, "SIGABRT", 7, "SIGBUS", 8, "SIGFPE", 9, "SIGKILL",
                    11, "SIGSEGV", 24, "SIGXCPU", 25, "SIGXFSZ", 31, "SIGSYS");
    private static final int FIRST_SIGNAL = 128;
    private static final int SIGKILL = 9;

    /**
     * Environment variables that a host receives, because loaders, drivers and the engine need
     * them. A host receives no other variables, because these may contain secrets.
     */
    private static final Set<String> KEPT_VARIABLES =
            Set.of("HOME", "PATH", "TMPDIR", "LANG", "VESPER_TEXT_MACHINE_CODE");

    /** Environment variable that names the virtual environment of laws in Python. */
    private static final String PYTHON = "VESPER_PYTHON";

    /**
     * Environment variable with settings of the C library, and the setting with which it requests
     * large pages. A host that replaces another host first touches all its memory in the repeated
     * frame. This would take most of the time of that frame with small pages.
     */
    private static final String TUNABLES = "GLIBC_TUNABLES";

    private static final String LARGE_PAGES = "glibc.malloc.hugetlb=1";

    private static final List<String> KEPT_PREFIXES =
            List.of("LD_", "OCL_", "POCL_", "XDG_", "ASAN_", "UBSAN_", "TSAN_", "LSAN_");

    private final SharedMemory control;
    private final Arena arena = Arena.ofShared();
    private final Process process;
    private final ProcessGroup group;
    private final SharedWord request;
    private final SharedWord reply;
    private final Mailbox mailbox;
    private boolean endsWhenInterrupted;
    private int requests;
    private long endedNanos = System.nanoTime();
    private long spentNanos;
    private long waitedNanos;

    /** Starts a host whose laws in Python use the packages of the system. */
    HostProcess(Path program, long memoryBytes) {
        this(program, memoryBytes, Optional.empty());
    }

    /**
     * Starts a host.
     *
     * @param python virtual environment of laws in Python
     * @throws IllegalStateException if the system refuses
     */
    HostProcess(Path program, long memoryBytes, Optional<Path> python) {
        control = new SharedMemory("vesper-host exchange", CONTROL_BYTES);
        MemorySegment memory = control.segment();
        request = word(memory, REQUEST);
        reply = word(memory, REPLY);
        mailbox = new Mailbox(memory.asSlice(MAILBOX));
        Process started = null;
        try {
            started = start(program, control.descriptor(), memoryBytes, python);
            startReading(started);
        } catch (IOException | OutOfMemoryError e) {
            // The error OutOfMemoryError means that no more threads are permitted.
            if (started != null) {
                started.destroyForcibly();
            }
            control.close();
            arena.close();
            throw new IllegalStateException(
                    "the engine's process " + program + " cannot be started: " + e.getMessage(), e);
        }
        process = started;
        group = new ProcessGroup(process.pid());
    }

    /**
     * Starts a platform thread that reads the output. A blocking read of a pipe on a virtual thread
     * would block its carrier thread. The pool of carrier threads ends its extra threads after 30 s
     * without work. Two such reads would then leave no carrier for other virtual threads on a
     * machine with two processors.
     */
    private static void startReading(Process started) {
        Thread.ofPlatform().daemon().name("output of laws").start(new OutputOfLaws(started, LOG));
    }

    private SharedWord word(MemorySegment memory, long offset) {
        return new SharedWord(
                memory.asSlice(offset, JAVA_INT), arena.allocate(2 * Long.BYTES, Long.BYTES));
    }

    private static Process start(
            Path program, int descriptor, long memoryBytes, Optional<Path> python)
            throws IOException {
        ProcessBuilder builder =
                new ProcessBuilder(
                        program.toString(),
                        Long.toString(ProcessHandle.current().pid()),
                        Integer.toString(descriptor),
                        Long.toString(memoryBytes));
        builder.environment()
                .keySet()
                .removeIf(
                        name ->
                                !KEPT_VARIABLES.contains(name)
                                        && KEPT_PREFIXES.stream().noneMatch(name::startsWith));
        builder.environment().put(TUNABLES, LARGE_PAGES);
        python.ifPresent(
                folder -> builder.environment().put(PYTHON, folder.toAbsolutePath().toString()));
        builder.redirectInput(ProcessBuilder.Redirect.from(Path.of("/dev/null").toFile()));
        builder.redirectErrorStream(true);
        return builder.start();
    }

    /** Begins a request; the caller appends the arguments. */
    Mailbox begin(Request number) {
        return mailbox.begin(number);
    }

    /** Makes later calls end the host if the calling thread is interrupted. */
    void endWhenInterrupted() {
        endsWhenInterrupted = true;
    }

    /**
     * Sends the request and returns the reply.
     *
     * @param limitNanos limit for the sum of processor time and idle time, after which the host is
     *     ended
     * @param log receives the log lines of the request
     * @throws HostLost if the host ended; this object must not be used after that
     */
    Mailbox call(long limitNanos, VesperLog log) throws HostLost {
        return call(limitNanos, word -> false, log);
    }

    /**
     * Sends the request like {@link #call(long, VesperLog)}. The host is not ended at the limit
     * while a law in a sandbox is running, because the host itself then ends that law.
     *
     * @param isApart returns whether a word that the host writes to name the running law names a
     *     law in a sandbox
     */
    Mailbox call(long limitNanos, LongPredicate isApart, VesperLog log) throws HostLost {
        mailbox.end();
        int number = ++requests;
        long start = System.nanoTime();
        boolean quick = start - endedNanos < QUICK_NANOS;
        request.announce(number);
        if (quick) {
            spin(number, start + AWAKE_NANOS);
        }
        awaitReply(number);
        spentNanos = Math.min(System.nanoTime() - start, LOOK_NANOS);
        waitedNanos = 0;
        if (reply.get() != number) {
            long from = System.nanoTime();
            long spent = new Wait(number, limitNanos, isApart).untilAnswered(log);
            spentNanos += spent;
            waitedNanos = System.nanoTime() - from - spent;
        }
        if (control.segment().get(JAVA_INT, LOG_USED) != 0) {
            passLog(log);
        }
        endedNanos = System.nanoTime();
        return mailbox.reply();
    }

    /** Waits for the reply for {@link #LOOK_NANOS}; ends early if the host has ended. */
    private void awaitReply(int number) {
        long until = System.nanoTime() + LOOK_NANOS;
        do {
            reply.await(number - 1, ALIVE_NANOS);
        } while (reply.get() != number && process.isAlive() && System.nanoTime() - until < 0);
    }

    /** Busy-waits for the reply, because waking this thread takes longer than most frames. */
    private void spin(int number, long untilNanos) {
        while (reply.get() != number && System.nanoTime() - untilNanos < 0) {
            Thread.onSpinWait();
        }
    }

    /** Returns the part of the last call's time that counts for the limit of {@link #call} [ns]. */
    long spentNanos() {
        return spentNanos;
    }

    /** Returns the part of the last call's time in which the host waited for a processor [ns]. */
    long waitedNanos() {
        return waitedNanos;
    }

    /** The wait for a reply, with a check of the host after each {@link #LOOK_NANOS}. */
    private final class Wait {
        private final int number;
        private final LongPredicate isApart;
        private final long start = System.nanoTime();
        private final CallTime time;
        private boolean continued;

        Wait(int number, long limitNanos, LongPredicate isApart) {
            this.number = number;
            this.isApart = isApart;
            time = new CallTime(limitNanos, group.cpuNanos());
        }

        /** Waits for the reply, and returns the time that counts for the limit [ns]. */
        long untilAnswered(VesperLog log) throws HostLost {
            for (long last = start; reply.get() != number; ) {
                if (!process.isAlive()) {
                    throw lost(ending(), spent(), false, log);
                }
                long now = System.nanoTime();
                count(Math.min(now - last, MOST_LOOK_NANOS));
                last = now;
                if (endsWhenInterrupted && Thread.currentThread().isInterrupted()) {
                    process.destroyForcibly();
                    throw new HostLost("interrupted", spent(), false, true, List.of(), "", 0);
                }
                if (time.isLate(isInSandbox())) {
                    kill();
                    throw lost(
                            "no answer within " + time.limitNanos() / 1_000_000 + " ms",
                            time.limitNanos(),
                            true,
                            log);
                }
                awaitReply(number);
            }
            time.counts(0, group.cpuNanos());
            return spent();
        }

        private boolean isInSandbox() {
            for (int thread = 0; thread < MAX_THREADS; thread++) {
                if (isApart.test(running(thread))) {
                    return true;
                }
            }
            return false;
        }

        /**
         * Returns the time that counts towards the limit [ns], but at most the elapsed time. The
         * processor time of several threads together may exceed the elapsed time.
         */
        private long spent() {
            return Math.min(time.spentNanos(), System.nanoTime() - start);
        }

        /**
         * Counts the time since the last check. A host that was stopped (SIGSTOP) is continued once
         * per call, because another program may have stopped it.
         */
        private void count(long elapsed) {
            if (time.counts(elapsed, group.cpuNanos())) {
                return;
            }
            ProcessGroup.State state = group.state();
            if (state == ProcessGroup.State.STOPPED && !continued) {
                continued = true;
                group.proceed();
            } else {
                time.countsWithoutProcessor(elapsed, state);
            }
        }
    }

    /** Returns the law that a thread of the host calls, or 0. */
    private long running(int thread) {
        return control.segment().get(JAVA_LONG, RUNNING + (long) thread * Long.BYTES);
    }

    private HostLost lost(String how, long spent, boolean late, VesperLog log) {
        passLog(log);
        boolean killed = !late && process.exitValue() == FIRST_SIGNAL + SIGKILL;
        List<Long> running = new ArrayList<>();
        for (int thread = 0; thread < MAX_THREADS; thread++) {
            long law = running(thread);
            if (law != 0 && !running.contains(law)) {
                running.add(law);
            }
        }
        String wrote =
                new Mailbox(control.segment().asSlice(WROTE, WROTE_BYTES)).getField(WROTE_BYTES);
        long offset = control.segment().get(JAVA_LONG, WROTE_OFFSET);
        close();
        return new HostLost(how, spent, late, killed, running, wrote, offset);
    }

    private String ending() {
        int code = process.exitValue();
        return code > FIRST_SIGNAL
                ? SIGNALS.getOrDefault(code - FIRST_SIGNAL, "signal " + (code - FIRST_SIGNAL))
                : "exit code " + code;
    }

    /** Passes the log lines of the newest request to the client's log. */
    private void passLog(VesperLog log) {
        MemorySegment memory = control.segment();
        MemorySegment lines =
                memory.asSlice(LOG_LINES, MAILBOX - LOG_LINES)
                        .asSlice(
                                0,
                                Math.clamp(memory.get(JAVA_INT, LOG_USED), 0, MAILBOX - LOG_LINES));
        Mailbox reader = new Mailbox(lines);
        for (long read = 0; read < lines.byteSize(); ) {
            int level = lines.get(JAVA_INT_UNALIGNED, read);
            String line;
            try {
                reader.getInt();
                line = reader.getText();
            } catch (IndexOutOfBoundsException spoiled) {
                break; // a law has overwritten this memory
            }
            pass(log, LEVELS[Math.clamp(level, 1, LEVELS.length) - 1], OutputOfLaws.escaped(line));
            read += 2 * Integer.BYTES + lines.get(JAVA_INT_UNALIGNED, read + Integer.BYTES);
        }
        int dropped = memory.get(JAVA_INT, LOG_DROPPED);
        if (dropped > 0) {
            pass(
                    log,
                    System.Logger.Level.WARNING,
                    dropped + " more log lines of this frame were dropped");
        }
        memory.set(JAVA_INT, LOG_USED, 0);
        memory.set(JAVA_INT, LOG_DROPPED, 0);
    }

    private static void pass(VesperLog log, System.Logger.Level level, String line) {
        try {
            log.log(level, line);
        } catch (RuntimeException failure) {
            LOG.warn("a log listener failed: {}", failure.toString());
        }
    }

    boolean isAlive() {
        return group.isAlive();
    }

    private void kill() {
        group.kill();
        process.destroyForcibly();
        try {
            process.waitFor(1, TimeUnit.SECONDS);
        } catch (InterruptedException e) {
            Thread.currentThread().interrupt();
        }
    }

    /** Ends the host and all processes that its laws started. Idempotent. */
    @Override
    public void close() {
        group.kill();
        process.destroyForcibly();
        control.close();
        if (arena.scope().isAlive()) {
            arena.close();
        }
    }
}
