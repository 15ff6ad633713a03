// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.protocol.Rope;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The connections whose sockets do not take what is written to them, and how much of the heap is
 * taken by what waits for them, what several wait for counted once: where it is too much, those are
 * cut that have been slow for the longest. Any thread.
 *
 * @param <C> a connection
 */
public final class SlowReaders<C> {

    /** A rest that counts; 4,096 connections may have less each. */
    private static final int LARGE_BYTES = 16 * 1024;

    private static final long MOST_BYTES = 256L * 1024 * 1024;

    /** Of a small heap. */
    private static final int SHARE = 8;

    private final long mostBytes;

    private static final Rope NOTHING = new Rope(new byte[0]);

    /** What waits for a connection: so much in its queue, and the rest of what was written. */
    private record Held(int queued, Rope rest) {}

    /** The slowest first. Guarded by this. */
    private final Map<C, Held> large = new LinkedHashMap<>();

    private long bytes;

    SlowReaders() {
        this(Math.min(MOST_BYTES, Runtime.getRuntime().maxMemory() / SHARE));
    }

    SlowReaders(long mostBytes) {
        this.mostBytes = mostBytes;
    }

    /** What was written to a connection waits for its socket. */
    synchronized void hold(C connection, Rope rest) {
        if (rest.size() > LARGE_BYTES) {
            release(connection);
            large.put(connection, new Held(0, rest));
            bytes += rest.hold();
        }
    }

    /** So much waits for a slow connection beside, in its queue. It keeps its place. */
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

    /** Its socket has taken all, or is closed. */
    synchronized void release(C connection) {
        Held held = large.remove(connection);
        if (held != null) {
            bytes -= held.queued + held.rest.release();
        }
    }

    /** Returns how much waits for slow connections. */
    public synchronized long bytes() {
        return bytes;
    }

    /** Those to cut so that what is left is not too much; they are forgotten. */
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
