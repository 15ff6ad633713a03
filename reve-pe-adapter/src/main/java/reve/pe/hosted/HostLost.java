// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import java.util.List;

/** The end of a host before it answered a request. */
final class HostLost extends Exception {
    private static final long serialVersionUID = 1L;

    /**
     * The time limit after which the client ended it, because it did not answer [ns]; 0 if it ended
     * by itself.
     */
    final long lateNanos;

    /** Whether SIGKILL ended it, which the system and other programs send, too. */
    final boolean killed;

    /** The laws that its threads were calling: id in the upper, 1 + index in the lower half. */
    final transient List<Long> running;

    /**
     * The read-only property at which it crashed, or empty, and the place in its column [bytes].
     */
    final String property;

    final long offset;

    /**
     * @param message how it ended, for example "SIGSEGV"
     */
    HostLost(
            String message,
            long lateNanos,
            boolean killed,
            List<Long> running,
            String property,
            long offset) {
        super(message, null, false, false);
        this.lateNanos = lateNanos;
        this.killed = killed;
        this.running = running;
        this.property = property;
        this.offset = offset;
    }

    /** Whether the client ended it. */
    boolean isLate() {
        return lateNanos > 0;
    }
}
