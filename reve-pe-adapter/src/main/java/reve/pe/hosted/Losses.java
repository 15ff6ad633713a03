// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.PhysicsException;
import reve.pe.Status;

import java.util.List;
import java.util.Optional;

/**
 * The lost hosts of an engine since its last successful advance, and the libraries that caused
 * them.
 */
final class Losses {
    /**
     * Maximum sum of the times of failed attempts to make a frame [ns]. It also applies to frames
     * in which laws may build data structures.
     */
    private static final long MOST_FAILED_NANOS = 4_000_000_000L;

    /**
     * Minimum time of the first attempt to make a frame [ns]. It applies if requests before the
     * frame have failed for a long time. Laws that only build their data structures would otherwise
     * be late.
     */
    private static final long LEAST_FIRST_NANOS = 1_000_000_000L;

    private final HostedProvider provider;

    /** The loaded libraries; the engine changes this list. */
    private final List<Loaded> libraries;

    private boolean alone;
    private long failedNanos;
    private boolean attempted;

    /** Number of successive losses by SIGKILL with the same library at which it is the cause. */
    private static final int MOST_KILLS = 5;

    /** Number of successive crashes with the same library at which it is the cause. */
    private static final int MOST_CRASHES = 2;

    /** Id of the library whose law ran when a host was lost; 0 for none. */
    private int suspected;

    /** Number of successive losses with the suspected library. */
    private int suspicions;

    Losses(HostedProvider provider, List<Loaded> libraries) {
        this.provider = provider;
        this.libraries = libraries;
    }

    /**
     * Returns whether laws must run one after the other. The result is true if several laws ran
     * when the last host ended. The next loss then shows which law is the cause.
     */
    boolean isAlone() {
        return alone;
    }

    /**
     * Returns the part of a time limit that remains in this frame [ns]. The failed attempts so far
     * reduce this part.
     */
    long left(long limitNanos) {
        return Math.clamp(MOST_FAILED_NANOS - failedNanos, 0, limitNanos);
    }

    /** Begins an attempt to make a frame. */
    void beginAttempt() {
        if (!attempted) {
            attempted = true;
            failedNanos = Math.min(failedNanos, MOST_FAILED_NANOS - LEAST_FIRST_NANOS);
        }
    }

    /** Adds the time of a request that did not make the frame [ns]. */
    void spend(long nanos) {
        failedNanos += nanos;
    }

    /** Discards the data about losses, because the frame succeeded. */
    void forget() {
        suspected = 0;
        failedNanos = 0;
        attempted = false;
    }

    /** Returns the failure of the law that ended the host, or did not return. */
    PhysicsException blame(HostLost lost) {
        List<Loaded> running =
                lost.running.stream()
                        .map(word -> (int) (word >>> Integer.SIZE))
                        .distinct()
                        .flatMap(id -> byHostId(id).stream())
                        .toList();
        alone = running.size() > 1;
        if (running.size() != 1) {
            return engineLost(
                    lost, (running.isEmpty() ? "no law" : running.size() + " libraries") + " ran");
        }
        Loaded library = running.getFirst();
        int law = (int) (lost.running.getFirst() & 0xFFFFFFFFL) - 1;
        if (lost.killed && mayHaveAnotherCause(library, MOST_KILLS)) {
            return engineLost(lost, "law " + library.lawName(law) + " ran");
        }
        long row = provider.row(lost.property, lost.offset);
        return exception(
                statusOf(lost),
                library,
                law,
                row < 0 ? "" : lost.property,
                row,
                lost.isLate()
                        ? lost.getMessage() + " of its frame"
                        : "ended the engine's process: "
                                + lost.getMessage()
                                + (row < 0
                                        ? ""
                                        : "; it wrote property "
                                                + lost.property
                                                + ", row "
                                                + row
                                                + ", which no loaded law declares to write"));
    }

    /** Returns the failure of a library during whose loading a new host ended or did not answer. */
    PhysicsException blameForLoad(HostLost lost, Loaded library) {
        if (!lost.isLate()
                && mayHaveAnotherCause(library, lost.killed ? MOST_KILLS : MOST_CRASHES)) {
            return engineLost(lost, "library " + library.library.name() + " was loaded");
        }
        String message = lost.getMessage() + " while it was loaded";
        return exception(statusOf(lost), library, 0, "", -1, message);
    }

    /**
     * Records that this library ran when a host was lost. Returns whether the loss may have another
     * cause, such as a lack of memory or another program.
     *
     * @param most number of successive losses with the same library at which it counts as the cause
     */
    private boolean mayHaveAnotherCause(Loaded library, int most) {
        suspicions = suspected == library.id ? suspicions + 1 : 1;
        suspected = library.id;
        return suspicions < most;
    }

    private static PhysicsException engineLost(HostLost lost, String meanwhile) {
        return new PhysicsException(
                Status.ENGINE_LOST,
                "the engine's process was lost (" + lost.getMessage() + ") while " + meanwhile);
    }

    static Status statusOf(HostLost lost) {
        return lost.isLate() ? Status.LAW_TIMED_OUT : Status.LAW_CRASHED;
    }

    /** Converts a failure that a host reported to an exception. */
    PhysicsException of(Wire.Failure failure) {
        Optional<Loaded> library = byHostId(failure.library());
        return failure.exception(
                library.map(found -> found.id).orElse(0),
                library.map(found -> found.library.name()).orElse(""),
                library.map(found -> found.lawName(failure.law())).orElse(""));
    }

    private Optional<Loaded> byHostId(int id) {
        return libraries.stream().filter(library -> library.hostId == id).findFirst();
    }

    private static PhysicsException exception(
            Status status, Loaded library, int law, String property, long row, String message) {
        String name = library.lawName(law);
        return new PhysicsException(
                status,
                library.id,
                library.library.name(),
                name,
                property,
                row,
                (name.isEmpty() ? "library " + library.library.name() : "law " + name)
                        + ": "
                        + message);
    }
}
