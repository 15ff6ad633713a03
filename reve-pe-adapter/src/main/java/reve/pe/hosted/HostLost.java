// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import java.util.List;

/** The end of a host before it answered a request. */
final class HostLost extends Exception {
    private static final long serialVersionUID = 1L;

    /** Whether the client ended it, because it did not answer in time. */
    final boolean late;

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
    HostLost(String message, boolean late, List<Long> running, String property, long offset) {
        super(message, null, false, false);
        this.late = late;
        this.running = running;
        this.property = property;
        this.offset = offset;
    }
}
