// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;
import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import java.nio.file.Path;
import java.util.Optional;
import java.util.concurrent.Callable;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.Executor;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.function.Supplier;

/**
 * Starts the processes of engines. One process is always started in advance, so that it can replace
 * a lost process at once. Engines that share this object also share this process. For any thread.
 */
public final class Hosts implements AutoCloseable {
    private static final Logger LOG = LoggerFactory.getLogger("laws");

    /** Maximum wait for the process started in advance, if its start is not finished [s]. */
    private static final long PATIENCE_SECONDS = 1;

    private final Supplier<HostProcess> starter;
    private final Executor later;
    private final AtomicInteger mayKeepReady = new AtomicInteger();
    private @Nullable CompletableFuture<HostProcess> warm;
    private boolean closed;

    /**
     * Creates an object whose laws in Python use the packages of the system.
     *
     * @param program path of the program {@code vesper-host} of a release
     * @param memoryBytes maximum private memory of each process; 0: no limit
     */
    public Hosts(Path program, long memoryBytes) {
        this(program, memoryBytes, Optional.empty());
    }

    /**
     * Creates an object that starts processes of a program.
     *
     * @param program path of the program {@code vesper-host} of a release
     * @param memoryBytes maximum private memory of each process; 0: no limit
     * @param python virtual environment whose packages laws in Python may import; empty: the
     *     packages of the system
     */
    public Hosts(Path program, long memoryBytes, Optional<Path> python) {
        this(
                () -> new HostProcess(program, memoryBytes, python),
                start -> Thread.ofPlatform().daemon().name("starts a host").start(start));
    }

    /**
     * @param starter starts a process
     * @param later executor that runs the starts in advance
     */
    Hosts(Supplier<HostProcess> starter, Executor later) {
        this.starter = starter;
        this.later = later;
    }

    /** Returns the process started in advance, or a new one. */
    HostProcess take() {
        CompletableFuture<HostProcess> ready;
        synchronized (this) {
            ready = warm;
            warm = null;
        }
        if (ready != null) {
            try {
                HostProcess host = ready.get(PATIENCE_SECONDS, TimeUnit.SECONDS);
                if (host.isAlive()) {
                    return host;
                }
                host.close();
            } catch (ExecutionException | TimeoutException notStarted) {
                // A process that becomes ready too late is closed. If its start failed, the start
                // below fails, too, and reports the reason.
                ready.thenAccept(HostProcess::close);
            } catch (InterruptedException e) {
                ready.thenAccept(HostProcess::close);
                Thread.currentThread().interrupt();
            }
        }
        return start();
    }

    /**
     * Starts the next process in advance on another thread, unless there is one. A failure is only
     * logged, because it only delays the replacement of a lost process.
     */
    public synchronized void refill() {
        if (warm == null && !closed) {
            try {
                warm = startLater();
            } catch (OutOfMemoryError noThread) {
                LOG.warn("no process waits for the next fault of a law: {}", noThread.getMessage());
            }
        }
    }

    /**
     * Permits engines to keep a second process each, which has already loaded the laws of the
     * engine. Such a process replaces a lost process faster than the process that all engines
     * share. By default, engines keep no such process.
     *
     * @param engines maximum number of engines that keep such a process at the same time
     */
    public void keepReady(int engines) {
        mayKeepReady.set(engines);
    }

    /** Returns whether one more engine may keep a process. If so, counts this engine. */
    boolean mayKeepReady() {
        return mayKeepReady.getAndUpdate(left -> Math.max(0, left - 1)) > 0;
    }

    /**
     * Records that an engine does not keep a process any more, so that another engine may do so.
     */
    void keepsReadyNoMore() {
        mayKeepReady.incrementAndGet();
    }

    /** Starts a process that is not kept for later. */
    HostProcess start() {
        return starter.get();
    }

    private CompletableFuture<HostProcess> startLater() {
        return later(this::start);
    }

    /** Runs a task that starts a process on another thread. */
    <T> CompletableFuture<T> later(Callable<T> start) {
        CompletableFuture<T> next = new CompletableFuture<>();
        later.execute(
                () -> {
                    try {
                        next.complete(start.call());
                    } catch (Throwable refused) {
                        // Errors are also caught, because the world would otherwise wait for ever.
                        next.completeExceptionally(refused);
                    }
                });
        return next;
    }

    /** Ends the process started in advance. Each engine ends its own processes. Idempotent. */
    @Override
    public void close() {
        CompletableFuture<HostProcess> last;
        synchronized (this) {
            closed = true;
            last = warm;
            warm = null;
        }
        if (last != null) {
            last.thenAccept(HostProcess::close);
        }
    }
}
