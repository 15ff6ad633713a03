// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

/**
 * A limit on the number of boxes and nodes that searches examine. Nested searches share it. It
 * counts work and not time, so that a search has the same result on every machine. For one thread.
 */
public final class Effort {
    private long left;

    /** Begins a new search that may examine this many boxes and nodes. */
    public void begin(long most) {
        left = most;
    }

    /** Counts examined boxes; returns false if the search must end without a result. */
    boolean spend(long count) {
        left -= count;
        return left >= 0;
    }

    /** Returns how many boxes and nodes the search may still examine; negative if it has ended. */
    public long left() {
        return left;
    }
}
