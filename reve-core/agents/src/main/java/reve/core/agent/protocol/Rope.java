// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.net.SlowReaders;

import java.nio.ByteBuffer;
import java.util.Arrays;

/**
 * Encoded bytes: some of its own and, between them, other ropes, which many ropes may hold. So what
 * many clients are sent is in memory once. Immutable, but for the count of its holders.
 */
public final class Rope {

    /** A rope of fewer bytes is copied into those that hold it [bytes]. */
    static final int LEAST_BYTES = 512;

    /** Memory of a strand within a rope, with its places [bytes]. */
    private static final int STRAND_BYTES = 12;

    private static final int[] NO_PLACES = {};
    private static final Rope[] NO_STRANDS = {};

    private final byte[] own;
    private final Rope[] strands;

    /** Where each strand begins in the rope, and behind how many own bytes. */
    private final int[] starts;

    private final int[] ownBefore;
    private final int size;

    /** Guarded by the {@link SlowReaders}. */
    private int holders;

    /** A rope of bytes that nobody changes any more. */
    public Rope(byte[] own) {
        this(own, NO_STRANDS, NO_PLACES);
    }

    /**
     * Owns all three arrays.
     *
     * @param ownBefore how many own bytes come before each strand, in ascending order
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

    /** Returns how many bytes there are, with those of other ropes. */
    public int size() {
        return size;
    }

    /** Returns all bytes in one array, which the caller does not change. */
    byte[] flat() {
        if (strands.length == 0) {
            return own;
        }
        var flat = ByteBuffer.allocate(size);
        get(0, flat);
        return flat.array();
    }

    /** Puts the bytes from an offset on into a buffer, as far as it has room. */
    public void get(int offset, ByteBuffer into) {
        int found = Arrays.binarySearch(starts, offset);
        int next = found >= 0 ? found : -found - 1;
        if (found < 0 && next > 0 && offset < starts[next - 1] + strands[next - 1].size) {
            next--; // the offset is within this strand
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
     * One more holder keeps the rope in memory.
     *
     * @return the memory that is held now and was not before [bytes]
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
     * One holder fewer.
     *
     * @return the memory that is not held any more [bytes]
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
