// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.protocol.Rope;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The connections whose clients read too slowly, and the memory of the data that waits for them.
 * Data that several connections share is counted once. The connections that have been slow the
 * longest are disconnected if the memory exceeds a limit. For any thread.
 *
 * @param <C> type of a connection
 */
public final class SlowReaders<C> {

    /**
     * Minimum size of the waiting data of a connection that this class counts [bytes]. Smaller
     * amounts are not counted, because even 4,096 such connections take little memory.
     */
    private static final int LARGE_BYTES = 16 * 1024;

    private static final long MOST_BYTES = 256L * 1024 * 1024;

    /** Divisor that computes the limit on the memory from the size of a small heap. */
    private static final int SHARE = 8;

    private final long mostBytes;

    private static final Rope NOTHING = new Rope(new byte[0]);

    /** Waiting data of a connection: number of bytes in its queue, and the data being written. */
    private record Held(int queued, Rope rest) {}

    /**
     * Waiting data by connection. The connection that has been slow the longest comes first.
     * Guarded by this object's lock.
     */
    private final Map<C, Held> large = new LinkedHashMap<>();

    private long bytes;

    SlowReaders() {
        this(Math.min(MOST_BYTES, Runtime.getRuntime().maxMemory() / SHARE));
    }

    SlowReaders(long mostBytes) {
        this.mostBytes = mostBytes;
    }

    /** Records that the socket of a connection has not accepted all bytes of {@code rest}. */
    synchronized void hold(C connection, Rope rest) {
        if (rest.size() > LARGE_BYTES) {
            release(connection);
            large.put(connection, new Held(0, rest));
            bytes += rest.hold();
        }
    }

    /**
     * Updates the number of bytes in the queue of a slow connection, which keeps its position in
     * the order.
     */
    synchronized void count(C connection, int queued) {
        Held before = large.get(connection);
        if (before == null && queued > LARGE_BYTES) {
            large.put(connection, new Held(queued, NOTHING));
            bytes += queued;
        } else if (before != null && before.rest == NOTHING && queued <= LARGE_BYTES) {
            release(connection);
        } else if (before != null) {
            large.put(connection, new Held(queued, before.rest));
            bytes += queued - before.queued;
        }
    }

    /** Removes a connection whose socket has accepted all data, or is closed. */
    synchronized void release(C connection) {
        Held held = large.remove(connection);
        if (held != null) {
            bytes -= held.queued + held.rest.release();
        }
    }

    /** Returns the memory of all waiting data [bytes]. */
    public synchronized long bytes() {
        return bytes;
    }

    /**
     * Removes the connections that must be disconnected to bring the data of the remaining
     * connections within the limit. Returns the removed connections.
     */
    synchronized List<C> excess() {
        var excess = new ArrayList<C>();
        while (bytes > mostBytes) {
            C slowest = large.keySet().iterator().next();
            release(slowest);
            excess.add(slowest);
        }
        return excess;
    }
}
