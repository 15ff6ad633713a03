// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.protocol.Rope;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * Connections whose sockets do not accept all data, and the memory of their waiting data. Data that
 * several connections share is counted once. Above a limit, the connections that have been slow the
 * longest are disconnected. Any thread.
 *
 * @param <C> a connection
 */
public final class SlowReaders<C> {

    /** Minimum size of counted data [bytes]; 4,096 connections with less are tolerated. */
    private static final int LARGE_BYTES = 16 * 1024;

    private static final long MOST_BYTES = 256L * 1024 * 1024;

    /** The limit is this fraction of a small heap. */
    private static final int SHARE = 8;

    private final long mostBytes;

    private static final Rope NOTHING = new Rope(new byte[0]);

    /** Waiting data of a connection: bytes in its queue, and the rest of the data being written. */
    private record Held(int queued, Rope rest) {}

    /** Slowest first. Guarded by this. */
    private final Map<C, Held> large = new LinkedHashMap<>();

    private long bytes;

    SlowReaders() {
        this(Math.min(MOST_BYTES, Runtime.getRuntime().maxMemory() / SHARE));
    }

    SlowReaders(long mostBytes) {
        this.mostBytes = mostBytes;
    }

    /** Records that the socket has not accepted {@code rest}. */
    synchronized void hold(C connection, Rope rest) {
        if (rest.size() > LARGE_BYTES) {
            release(connection);
            large.put(connection, new Held(0, rest));
            bytes += rest.hold();
        }
    }

    /** Updates the bytes in the queue of a slow connection. Its position is kept. */
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

    /** Removes and returns the connections to disconnect, so that the rest is below the limit. */
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
