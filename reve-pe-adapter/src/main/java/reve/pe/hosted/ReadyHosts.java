// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import org.jspecify.annotations.Nullable;

import reve.pe.Prototype;
import reve.pe.vesper.VesperConfig;

import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.CompletableFuture;

/**
 * The host that an engine keeps ready with its libraries. The engine starts it on another thread
 * some frames after the libraries changed. For the thread of the engine.
 */
final class ReadyHosts implements AutoCloseable {
    /** Number of frames without a change of the libraries after which a host is started. */
    static final int FRAMES = 10;

    private static final long LIMIT_NANOS = Duration.ofSeconds(3).toNanos();

    private final Hosts hosts;
    private final VesperConfig config;
    private final Prototype prototype;

    /** The libraries at the last frame. */
    private final List<Loaded> known = new ArrayList<>();

    private int frames;
    private @Nullable CompletableFuture<ReadyHost> next;

    ReadyHosts(Hosts hosts, VesperConfig config, Prototype prototype) {
        this.hosts = hosts;
        this.config = config;
        this.prototype = prototype;
    }

    /**
     * Counts a successful frame with these libraries. Allocates nothing while the libraries stay
     * the same.
     */
    void count(List<Loaded> libraries) {
        if (!known.equals(libraries)) {
            close();
            known.clear();
            known.addAll(libraries);
        } else if (frames < FRAMES && ++frames == FRAMES && mayStart()) {
            start(List.copyOf(libraries));
        }
    }

    private void start(List<Loaded> now) {
        try {
            next = hosts.later(() -> ReadyHost.start(hosts, config, prototype, now, LIMIT_NANOS));
        } catch (OutOfMemoryError noThread) {
            // No thread can be started, so the process that all engines share must be sufficient.
            hosts.keepsReadyNoMore();
        }
    }

    /**
     * Returns whether a host may be started. No host is started for a world with a library in a
     * sandbox, because the sandbox is another process that must not run twice.
     */
    private boolean mayStart() {
        return !known.isEmpty()
                && known.stream().noneMatch(loaded -> loaded.library.isApart())
                && hosts.mayKeepReady();
    }

    /** Returns the host that is ready for these libraries. The caller then owns the host. */
    @Nullable ReadyHost take(List<Loaded> libraries) {
        CompletableFuture<ReadyHost> taken = next;
        if (taken == null
                || !taken.isDone()
                || taken.isCompletedExceptionally()
                || !taken.join().fits(libraries)) {
            return null;
        }
        next = null;
        hosts.keepsReadyNoMore();
        return taken.join();
    }

    /** Ends the host that is ready. The next one is started some frames later. Idempotent. */
    @Override
    public void close() {
        frames = 0;
        if (next != null) {
            next.thenAccept(ReadyHost::close);
            next = null;
            hosts.keepsReadyNoMore();
        }
    }
}
