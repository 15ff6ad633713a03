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
        return Arrays.copyOf(bytes.array(), size());
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
            bytes = ByteBuffer.wrap(Arrays.copyOf(bytes.array(), Math.max(needed, doubled))).position(size());
        }
        return bytes;
    }
}
