// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.net.SlowReaders;

import java.nio.ByteBuffer;
import java.util.Arrays;

/**
 * A sequence of encoded bytes. It consists of own bytes and of references to other ropes (strands),
 * which several ropes may share. Therefore data for many clients is in memory only once. Immutable
 * except for the number of holders.
 */
public final class Rope {

    /**
     * Minimum size of a rope that another rope references [bytes]. Smaller ropes are copied
     * instead.
     */
    static final int LEAST_BYTES = 512;

    /** Memory that a reference to a strand takes, including its positions [bytes]. */
    private static final int STRAND_BYTES = 12;

    private static final int[] NO_PLACES = {};
    private static final Rope[] NO_STRANDS = {};

    private final byte[] own;
    private final Rope[] strands;

    /**
     * Position of each strand in the rope. The next field contains the number of own bytes before
     * each strand.
     */
    private final int[] starts;

    private final int[] ownBefore;
    private final int size;

    /** Number of holders. Guarded by the lock of {@link SlowReaders}. */
    private int holders;

    /** Creates a rope that owns the bytes. The caller must not change them afterwards. */
    public Rope(byte[] own) {
        this(own, NO_STRANDS, NO_PLACES);
    }

    /**
     * Creates a rope that owns all three arrays. The caller must not change them afterwards.
     *
     * @param ownBefore number of own bytes before each strand, in ascending order
     */
    public Rope(byte[] own, Rope[] strands, int[] ownBefore) {
        this.own = own;
        this.strands = strands;
        this.ownBefore = ownBefore;
        this.starts = strands.length == 0 ? NO_PLACES : new int[strands.length];
        int before = 0;
        for (int i = 0; i < strands.length; i++) {
            starts[i] = ownBefore[i] + before;
            before = Math.addExact(before, strands[i].size);
        }
        this.size = Math.addExact(own.length, before);
    }

    /** Returns the number of bytes, including strands. */
    public int size() {
        return size;
    }

    /** Returns all bytes in one array, which the caller must not change. */
    byte[] flat() {
        if (strands.length == 0) {
            return own;
        }
        var flat = ByteBuffer.allocate(size);
        get(0, flat);
        return flat.array();
    }

    /** Copies bytes from {@code offset} into a buffer until it is full. */
    public void get(int offset, ByteBuffer into) {
        int found = Arrays.binarySearch(starts, offset);
        int next = found >= 0 ? found : -found - 1;
        if (found < 0 && next > 0 && offset < starts[next - 1] + strands[next - 1].size) {
            next--; // the offset is within the previous strand
        }
        int at = offset;
        for (; next < strands.length && into.hasRemaining(); next++) {
            int start = starts[next];
            if (at < start) {
                at += putOwn(ownBefore[next] - (start - at), start - at, into);
            }
            strands[next].get(at - start, into);
            at = start + strands[next].size;
        }
        if (at < size && into.hasRemaining()) {
            putOwn(own.length - (size - at), size - at, into);
        }
    }

    private int putOwn(int from, int count, ByteBuffer into) {
        into.put(own, from, Math.min(count, into.remaining()));
        return count;
    }

    /**
     * Adds a holder. A holder is a slow connection that keeps the rope in memory.
     *
     * @return memory that had no holder before [bytes]
     */
    public long hold() {
        if (holders++ > 0) {
            return 0;
        }
        long bytes = memory();
        for (Rope strand : strands) {
            bytes += strand.hold();
        }
        return bytes;
    }

    /**
     * Removes a holder of the rope.
     *
     * @return memory that lost its last holder [bytes]
     */
    public long release() {
        if (--holders > 0) {
            return 0;
        }
        long bytes = memory();
        for (Rope strand : strands) {
            bytes += strand.release();
        }
        return bytes;
    }

    private long memory() {
        return own.length + (long) STRAND_BYTES * strands.length;
    }
}
