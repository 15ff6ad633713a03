// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The connections whose sockets do not take what is written to them, and how much of the heap is
 * taken by what waits for them: where it is too much, those are cut that have been slow for the
 * longest. Any thread.
 *
 * @param <C> a connection
 */
final class SlowReaders<C> {

    /** A rest that counts; 4,096 connections may have less each. */
    private static final int LARGE_BYTES = 16 * 1024;

    private static final long MOST_BYTES = 256L * 1024 * 1024;

    /** Of a small heap. */
    private static final int SHARE = 8;

    private final long mostBytes;

    /** The slowest first. Guarded by this. */
    private final Map<C, Integer> large = new LinkedHashMap<>();

    private long bytes;

    SlowReaders() {
        this(Math.min(MOST_BYTES, Runtime.getRuntime().maxMemory() / SHARE));
    }

    SlowReaders(long mostBytes) {
        this.mostBytes = mostBytes;
    }

    /** So much of what was written to a connection waits for its socket. */
    synchronized void hold(C connection, int rest) {
        if (rest > LARGE_BYTES) {
            release(connection);
            large.put(connection, rest);
            bytes += rest;
        }
    }

    /** So much waits for a slow connection by now, in its queue too. It keeps its place. */
    synchronized void count(C connection, int rest) {
        if (rest > LARGE_BYTES) {
            Integer before = large.put(connection, rest);
            bytes += rest - (before == null ? 0 : before);
        } else {
            release(connection);
        }
    }

    /** Its socket has taken all, or is closed. */
    synchronized void release(C connection) {
        Integer rest = large.remove(connection);
        if (rest != null) {
            bytes -= rest;
        }
    }

    /** Returns how much waits for slow connections. */
    synchronized long bytes() {
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
