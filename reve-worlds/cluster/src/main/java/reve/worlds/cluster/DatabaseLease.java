// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cluster;

import org.apache.pekko.coordination.lease.LeaseSettings;
import org.apache.pekko.coordination.lease.javadsl.Lease;

import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresUrl;

import java.io.IOException;
import java.time.Duration;
import java.util.Optional;
import java.util.UUID;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionException;
import java.util.concurrent.CompletionStage;
import java.util.concurrent.Executor;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;

/**
 * A lease in the database of the worlds. A network failure may divide the nodes of a cluster into
 * parts. The part that takes the lease continues. The owner extends the lease until it releases it.
 * For any thread.
 *
 * <p>Pekko creates the object, from the section {@code reve.lease} of the configuration.
 */
public final class DatabaseLease extends Lease {
    /** Interval between two attempts to reach the database [ns]. */
    private static final long ATTEMPT_NANOSECONDS = 250_000_000L;

    private static final Executor THREADS =
            task -> Thread.ofVirtual().name("lease of a cluster").start(task);

    private final LeaseSettings settings;
    private final String owner;
    private final Duration length;
    private final PostgresCatalog catalog;
    private volatile boolean held;
    private volatile long confirmedNanos;

    /** Creates the lease without taking it; connects at the first use. */
    public DatabaseLease(LeaseSettings settings) {
        PostgresUrl database =
                PostgresUrl.find(settings.leaseConfig().getString("store")).orElseThrow();
        this.settings = settings;
        this.owner = settings.ownerName() + " " + UUID.randomUUID();
        this.length = settings.timeoutSettings().getHeartbeatTimeout();
        this.catalog = new PostgresCatalog(database);
    }

    @Override
    public LeaseSettings getSettings() {
        return settings;
    }

    @Override
    public CompletionStage<Boolean> acquire() {
        return acquire(_ -> {});
    }

    @Override
    public CompletionStage<Boolean> acquire(Consumer<Optional<Throwable>> leaseLost) {
        return CompletableFuture.supplyAsync(this::take, THREADS)
                .whenComplete(
                        (isTaken, failure) -> {
                            if (failure == null && isTaken) {
                                THREADS.execute(() -> extend(leaseLost));
                            }
                        });
    }

    /**
     * Takes the lease. Waits as long as the lease of a lost owner lasts if another owner has the
     * lease. Tries again until the time limit of an operation if the database is away.
     *
     * @return false if another owner extends the lease, or the lease does not end
     */
    private boolean take() {
        long start = System.nanoTime();
        Optional<String> seen = Optional.empty();
        while (true) {
            long now = System.nanoTime();
            try {
                if (catalog.takeLease(settings.leaseName(), owner, length)) {
                    confirmedNanos = now;
                    held = true;
                    return true;
                }
                Optional<String> end = catalog.leaseEnd(settings.leaseName());
                boolean isExtended = seen.isPresent() && end.isPresent() && !end.equals(seen);
                if (isExtended || now - start > 2 * length.toNanos()) {
                    return false;
                }
                seen = end;
            } catch (IOException away) {
                if (now - start > settings.timeoutSettings().getOperationTimeout().toNanos()) {
                    throw new CompletionException(away);
                }
            }
            LockSupport.parkNanos(ATTEMPT_NANOSECONDS);
        }
    }

    private void extend(Consumer<Optional<Throwable>> leaseLost) {
        while (held) {
            LockSupport.parkNanos(settings.timeoutSettings().getHeartbeatInterval().toNanos());
            Optional<Throwable> failure = Optional.empty();
            boolean isLost;
            synchronized (catalog) {
                // The lock ensures that a released lease is not taken again.
                if (!held) {
                    return;
                }
                long now = System.nanoTime();
                boolean isDenied = false;
                try {
                    isDenied = !catalog.takeLease(settings.leaseName(), owner, length);
                    confirmedNanos = isDenied ? confirmedNanos : now;
                } catch (IOException away) {
                    failure = Optional.of(away);
                }
                isLost = isDenied || !isConfirmed();
                if (isLost) {
                    // The value is never set to true here, because the lease may have been released
                    // meanwhile.
                    held = false;
                }
            }
            if (isLost) {
                leaseLost.accept(failure);
            }
        }
    }

    private boolean isConfirmed() {
        return System.nanoTime() - confirmedNanos < length.toNanos();
    }

    @Override
    public CompletionStage<Boolean> release() {
        held = false;
        return CompletableFuture.supplyAsync(
                () -> {
                    try {
                        synchronized (catalog) {
                            catalog.endLease(settings.leaseName(), owner);
                        }
                        return true;
                    } catch (IOException away) {
                        throw new CompletionException(away);
                    }
                },
                THREADS);
    }

    @Override
    public boolean checkLease() {
        return held && isConfirmed();
    }
}
