// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;

/**
 * A reusable, growing byte buffer for encoding. It contains large {@link Rope}s by reference,
 * without copying them. For one thread.
 */
public final class Bytes {

    private ByteBuffer bytes = ByteBuffer.allocate(64);

    /**
     * The ropes that the buffer contains by reference. The next field contains a number for each
     * rope: the count of own bytes in {@link #bytes} before the rope.
     */
    private Rope[] strands = new Rope[8];

    private int[] bytesBefore = new int[8];
    private int strandCount;
    private int strandBytes;

    /** Removes all bytes. */
    public Bytes clear() {
        bytes.clear();
        dropStrands(0);
        return this;
    }

    /** Returns the number of bytes, including those of ropes. */
    public int size() {
        return bytes.position() + strandBytes;
    }

    /** Returns whether the buffer contains ropes by reference. */
    public boolean hasStrands() {
        return strandCount > 0;
    }

    /** Returns a copy of all bytes. */
    public byte[] toArray() {
        return rope(0).flat();
    }

    /** Returns an immutable copy from position {@code start} to the end. */
    public Rope rope(int start) {
        int first = firstStrand(start);
        int from = ownPlace(start, first);
        byte[] own = Arrays.copyOfRange(bytes.array(), from, bytes.position());
        if (first == strandCount) {
            return new Rope(own);
        }
        int[] before = Arrays.copyOfRange(bytesBefore, first, strandCount);
        for (int i = 0; i < before.length; i++) {
            before[i] -= from;
        }
        return new Rope(own, Arrays.copyOfRange(strands, first, strandCount), before);
    }

    /** Returns the bytes from position {@code start}, valid until the next write. */
    public ByteBuffer view(int start) {
        return hasStrands()
                ? ByteBuffer.wrap(rope(start).flat())
                : ByteBuffer.wrap(bytes.array(), start, size() - start).slice();
    }

    /**
     * Copies bytes from position {@code start} into a buffer until it is full. The buffer must not
     * contain ropes.
     */
    public void get(int start, ByteBuffer into) {
        into.put(bytes.array(), start, Math.min(into.remaining(), size() - start));
    }

    /** Removes the bytes from position {@code start}. */
    void truncate(int start) {
        int first = firstStrand(start);
        bytes.position(ownPlace(start, first));
        dropStrands(first);
    }

    /** Overwrites 4 own bytes, which must not overlap a rope, with a big-endian number. */
    void setInt(int at, int number) {
        bytes.putInt(ownPlace(at, firstStrand(at)), number);
    }

    /** Appends a rope: a large one by reference, a small one as a copy. */
    public Bytes put(Rope rope) {
        if (rope.size() < Rope.LEAST_BYTES) {
            return put(rope.flat());
        }
        if (strandCount == strands.length) {
            strands = Arrays.copyOf(strands, 2 * strandCount);
            bytesBefore = Arrays.copyOf(bytesBefore, 2 * strandCount);
        }
        bytesBefore[strandCount] = bytes.position();
        strands[strandCount++] = rope;
        strandBytes = Math.addExact(strandBytes, rope.size());
        return this;
    }

    /** Returns the index of the first rope at or after a position. */
    private int firstStrand(int place) {
        int first = strandCount;
        int start = strandBytes;
        while (first > 0) {
            start -= strands[first - 1].size();
            if (bytesBefore[first - 1] + start < place) {
                break;
            }
            first--;
        }
        return first;
    }

    /**
     * Converts a position in the buffer into a position in {@link #bytes}.
     *
     * @param firstStrand index of the first rope after the position
     */
    private int ownPlace(int place, int firstStrand) {
        int before = strandBytes;
        for (int i = firstStrand; i < strandCount; i++) {
            before -= strands[i].size();
        }
        return place - before;
    }

    private void dropStrands(int first) {
        for (int i = first; i < strandCount; i++) {
            strandBytes -= strands[i].size();
        }
        Arrays.fill(strands, first, strandCount, null);
        strandCount = first;
    }

    /** Appends one byte. */
    public Bytes put(int octet) {
        room(1).put((byte) octet);
        return this;
    }

    /** Appends a copy of the bytes. */
    public Bytes put(byte[] octets) {
        room(octets.length).put(octets);
        return this;
    }

    /** Appends the text in UTF-8. */
    public Bytes put(String text) {
        int length = text.length();
        ByteBuffer room = room(length);
        for (int i = 0; i < length; i++) {
            char c = text.charAt(i);
            if (c >= 0x80) {
                return put(text.substring(i).getBytes(StandardCharsets.UTF_8));
            }
            room.put((byte) c);
        }
        return this;
    }

    /** Appends the number in decimal digits. */
    public Bytes put(long number) {
        return put(Long.toString(number));
    }

    Bytes putShort(int number) {
        room(Short.BYTES).putShort((short) number);
        return this;
    }

    /** Appends 4 bytes in big-endian order. */
    public Bytes putInt(int number) {
        room(Integer.BYTES).putInt(number);
        return this;
    }

    Bytes putLong(long number) {
        room(Long.BYTES).putLong(number);
        return this;
    }

    Bytes putDouble(double number) {
        room(Double.BYTES).putDouble(number);
        return this;
    }

    private ByteBuffer room(int count) {
        if (bytes.remaining() < count) {
            int needed = Math.addExact(bytes.position(), count);
            int doubled = (int) Math.min(2L * bytes.capacity(), Integer.MAX_VALUE - 8);
            byte[] larger = Arrays.copyOf(bytes.array(), Math.max(needed, doubled));
            bytes = ByteBuffer.wrap(larger).position(bytes.position());
        }
        return bytes;
    }
}
