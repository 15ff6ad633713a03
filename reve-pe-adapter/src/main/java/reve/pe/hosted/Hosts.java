// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import java.nio.file.Path;
import java.util.concurrent.CompletableFuture;

/**
 * Starts the processes of engines. One of them waits warm, so that the successor of a lost process
 * is there at once. Any thread; engines that share one of these also share the warm process.
 */
public final class Hosts implements AutoCloseable {
    private final Path program;
    private final long memoryBytes;
    private @Nullable CompletableFuture<HostProcess> warm;
    private boolean closed;

    /**
     * @param program the file {@code vesper-host} of a release
     * @param memoryBytes maximum private memory of each process; 0: no limit
     */
    public Hosts(Path program, long memoryBytes) {
        this.program = program;
        this.memoryBytes = memoryBytes;
    }

    /** Returns the warm process, or a new one. */
    HostProcess take() {
        CompletableFuture<HostProcess> ready;
        synchronized (this) {
            ready = warm;
            warm = null;
        }
        if (ready != null) {
            try {
                HostProcess host = ready.join();
                if (host.isAlive()) {
                    return host;
                }
                host.close();
            } catch (RuntimeException notStarted) {
                // the caller's own attempt gives the reason
            }
        }
        return start();
    }

    /** Starts the next warm process on another thread, unless there is one. */
    synchronized void refill() {
        if (warm == null && !closed) {
            warm = startLater();
        }
    }

    /** Starts a process for one use. */
    HostProcess start() {
        return new HostProcess(program, memoryBytes);
    }

    private CompletableFuture<HostProcess> startLater() {
        CompletableFuture<HostProcess> next = new CompletableFuture<>();
        Thread.ofPlatform()
                .daemon()
                .name("starts a host")
                .start(
                        () -> {
                            try {
                                next.complete(start());
                            } catch (RuntimeException refused) {
                                next.completeExceptionally(refused);
                            }
                        });
        return next;
    }

    /** Ends the warm process; engines end theirs. Idempotent. */
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
