package reve.core.agent;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * The connections whose sockets do not take what is written to them, and how much of the heap that
 * takes: where it is too much, those are cut that have been slow for the longest. Any thread.
 */
final class SlowReaders {

    /** A rest that counts; 4,096 connections may have less each. */
    private static final int LARGE_BYTES = 16 * 1024;
    /** Of the heap. */
    private static final int SHARE = 8;

    private final long mostBytes;
    /** The slowest first. Guarded by this. */
    private final Map<Connection, Integer> large = new LinkedHashMap<>();
    private long bytes;

    SlowReaders() {
        this(Runtime.getRuntime().maxMemory() / SHARE);
    }

    SlowReaders(long mostBytes) {
        this.mostBytes = mostBytes;
    }

    /** So much of what was written to a connection waits for its socket. */
    synchronized void hold(Connection connection, int rest) {
        if (rest > LARGE_BYTES) {
            release(connection);
            large.put(connection, rest);
            bytes += rest;
        }
    }

    /** Its socket has taken all, or is closed. */
    synchronized void release(Connection connection) {
        Integer rest = large.remove(connection);
        if (rest != null) {
            bytes -= rest;
        }
    }

    /** Those to cut so that what is left is not too much; they are forgotten. */
    synchronized List<Connection> excess() {
        var excess = new ArrayList<Connection>();
        while (bytes > mostBytes) {
            Connection slowest = large.keySet().iterator().next();
            release(slowest);
            excess.add(slowest);
        }
        return excess;
    }
}
