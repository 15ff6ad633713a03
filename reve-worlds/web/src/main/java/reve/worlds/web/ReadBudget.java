// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import java.util.concurrent.TimeUnit;
import java.util.function.IntSupplier;
import java.util.function.LongSupplier;

/**
 * The bytes that the server may read from one connection now. A client that sends more waits, so a
 * few busy connections leave time for the others. All connections together have {@link
 * #ALL_PER_SECOND}, in equal parts. Requests that cost more than their bytes are charged more. Any
 * thread.
 */
final class ReadBudget {

    /** Bytes a second of all connections together; no connection has more than a 32nd. */
    static final double ALL_PER_SECOND = 4 << 20;

    private static final int FEWEST_PARTS = 32;

    /** Bytes that a connection may send at once after a silence; a line has at most as many. */
    static final int BURST = 65_536;

    /** Bytes that the server charges for one HTTP request, or one ping of a WebSocket. */
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

    /** Returns the time until the server may read from the connection again [ns]; 0: now. */
    synchronized long waitNanos() {
        refill();
        return left >= 0 ? 0 : (long) Math.ceil(-left / perNano());
    }

    /** Charges a request, and waits until its turn. Only for virtual threads. */
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
