// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import java.util.concurrent.TimeUnit;
import java.util.function.IntSupplier;
import java.util.function.LongSupplier;

/**
 * The number of bytes that the server may read from one connection now. A client that sends more
 * must wait, so a few busy connections leave time for the others. All connections together have
 * {@link #ALL_PER_SECOND}, in equal parts. A request that costs more time than its bytes is charged
 * additional bytes. For any thread.
 */
final class ReadBudget {

    /**
     * Maximum rate of all connections together [bytes/s]. One connection has at most 1/32 of this
     * rate.
     */
    static final double ALL_PER_SECOND = 4 << 20;

    private static final int FEWEST_PARTS = 32;

    /**
     * Maximum number of bytes that a connection may send at once after a pause [bytes]. It equals
     * the maximum length of a line.
     */
    static final int BURST = 65_536;

    /** Charge for one HTTP request, or for one ping of a WebSocket [bytes]. */
    static final int REQUEST_BYTES = 2048;

    private final IntSupplier connections;
    private final LongSupplier clock;
    private double left = BURST;
    private long lastNanos;

    /**
     * @param connections returns the number of open connections
     * @param clock a clock like {@link System#nanoTime}
     */
    ReadBudget(IntSupplier connections, LongSupplier clock) {
        this.connections = connections;
        this.clock = clock;
        lastNanos = clock.getAsLong();
    }

    /** Charges bytes that were read. */
    synchronized void spend(int bytes) {
        refill();
        left -= bytes;
    }

    /**
     * Returns the time until the server may read from the connection again [ns]. Returns 0 if it
     * may read now.
     */
    synchronized long waitNanos() {
        refill();
        return left >= 0 ? 0 : (long) Math.ceil(-left / perNano());
    }

    /**
     * Charges a request, and waits until the budget permits it. For virtual threads only, because
     * this method blocks.
     */
    void takeRequest() throws InterruptedException {
        spend(REQUEST_BYTES);
        TimeUnit.NANOSECONDS.sleep(waitNanos());
    }

    private void refill() {
        long now = clock.getAsLong();
        left = Math.min(BURST, left + (now - lastNanos) * perNano());
        lastNanos = now;
    }

    private double perNano() {
        return ALL_PER_SECOND / Math.max(FEWEST_PARTS, connections.getAsInt()) / 1e9;
    }
}
