// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;

/** Bytes that are being written, in memory that grows and is used again. One thread. */
final class Bytes {

    private ByteBuffer bytes = ByteBuffer.allocate(64);

    Bytes clear() {
        bytes.clear();
        return this;
    }

    int size() {
        return bytes.position();
    }

    byte[] toArray() {
        return copy(0);
    }

    /** What was written from a place on. */
    byte[] copy(int start) {
        return Arrays.copyOfRange(bytes.array(), start, size());
    }

    /** What was written from a place on, in place: valid until more is written. */
    ByteBuffer view(int start) {
        return ByteBuffer.wrap(bytes.array(), start, size() - start).slice();
    }

    /** Puts what was written from a place on into a buffer, as far as it has room. */
    void get(int start, ByteBuffer into) {
        into.put(bytes.array(), start, Math.min(into.remaining(), size() - start));
    }

    /** Writes over what is there. */
    void setInt(int at, int number) {
        bytes.putInt(at, number);
    }

    Bytes put(int octet) {
        room(1).put((byte) octet);
        return this;
    }

    Bytes put(byte[] octets) {
        room(octets.length).put(octets);
        return this;
    }

    /** In UTF-8. */
    Bytes put(String text) {
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

    /** In decimal digits. */
    Bytes put(long number) {
        return put(Long.toString(number));
    }

    Bytes putShort(int number) {
        room(Short.BYTES).putShort((short) number);
        return this;
    }

    Bytes putInt(int number) {
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
            int needed = Math.addExact(size(), count);
            int doubled = (int) Math.min(2L * bytes.capacity(), Integer.MAX_VALUE - 8);
            byte[] larger = Arrays.copyOf(bytes.array(), Math.max(needed, doubled));
            bytes = ByteBuffer.wrap(larger).position(size());
        }
        return bytes;
    }
}
