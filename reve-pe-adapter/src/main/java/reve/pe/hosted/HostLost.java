// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import java.util.List;

/** Thrown if a host (an engine's process) ended before it answered a request. */
final class HostLost extends Exception {
    private static final long serialVersionUID = 1L;

    /** The time of the request as it counts for its time limit [ns]. */
    final long spentNanos;

    private final boolean late;

    /**
     * True if the signal SIGKILL ended the host. This client, the system or another program may
     * have sent the signal.
     */
    final boolean killed;

    /**
     * The laws that the host's threads were calling. Each number contains the library's id in the
     * upper half and 1 + the law's index in the lower half.
     */
    final transient List<Long> running;

    /**
     * The name of the read-only property whose write caused the crash; empty for other losses. The
     * next field is the offset of the write in its column [bytes].
     */
    final String property;

    final long offset;

    /**
     * @param message the way in which the host ended, for example "SIGSEGV"
     * @param spentNanos the time of the request as it counts for its time limit [ns]
     * @param late whether the client ended the host because it did not answer in time
     */
    HostLost(
            String message,
            long spentNanos,
            boolean late,
            boolean killed,
            List<Long> running,
            String property,
            long offset) {
        super(message, null, false, false);
        this.spentNanos = spentNanos;
        this.late = late;
        this.killed = killed;
        this.running = running;
        this.property = property;
        this.offset = offset;
    }

    /** Returns whether the client ended the host because it did not answer in time. */
    boolean isLate() {
        return late;
    }
}
