// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import static java.lang.foreign.ValueLayout.JAVA_BYTE;
import static java.lang.foreign.ValueLayout.JAVA_DOUBLE_UNALIGNED;
import static java.lang.foreign.ValueLayout.JAVA_INT_UNALIGNED;
import static java.lang.foreign.ValueLayout.JAVA_LONG_UNALIGNED;

import reve.pe.SiUnit;

import java.lang.foreign.MemorySegment;
import java.nio.charset.StandardCharsets;

/**
 * The memory in which a client writes a request and then reads the reply, from front to back. A
 * faulty law may have written any numbers into it. Therefore a read beyond its end is checked, and
 * throws IndexOutOfBoundsException.
 */
final class Mailbox {
    private static final int EXPONENTS = 7;

    private final MemorySegment memory;
    private long at;

    Mailbox(MemorySegment memory) {
        this.memory = memory;
    }

    /** Begins a request. */
    Mailbox begin(Request request) {
        at = Integer.BYTES; // the first bytes are for the size
        return putInt(request.number());
    }

    /** Completes the request: writes its size at its beginning. */
    void end() {
        memory.set(JAVA_INT_UNALIGNED, 0, (int) (at - Integer.BYTES));
    }

    /** Moves the position to the beginning of the reply. */
    Mailbox reply() {
        at = 0;
        return this;
    }

    Mailbox putInt(int value) {
        memory.set(JAVA_INT_UNALIGNED, at, value);
        at += Integer.BYTES;
        return this;
    }

    Mailbox putLong(long value) {
        memory.set(JAVA_LONG_UNALIGNED, at, value);
        at += Long.BYTES;
        return this;
    }

    Mailbox putDouble(double value) {
        memory.set(JAVA_DOUBLE_UNALIGNED, at, value);
        at += Double.BYTES;
        return this;
    }

    Mailbox putText(String text) {
        byte[] bytes = text.getBytes(StandardCharsets.UTF_8);
        putInt(bytes.length);
        return putBytes(bytes);
    }

    Mailbox putUnit(SiUnit unit) {
        return putBytes(unit.exponents()).putDouble(unit.scale()).putText(unit.symbol());
    }

    private Mailbox putBytes(byte[] bytes) {
        MemorySegment.copy(bytes, 0, memory, JAVA_BYTE, at, bytes.length);
        at += bytes.length;
        return this;
    }

    int getInt() {
        int value = memory.get(JAVA_INT_UNALIGNED, at);
        at += Integer.BYTES;
        return value;
    }

    long getLong() {
        long value = memory.get(JAVA_LONG_UNALIGNED, at);
        at += Long.BYTES;
        return value;
    }

    double getDouble() {
        double value = memory.get(JAVA_DOUBLE_UNALIGNED, at);
        at += Double.BYTES;
        return value;
    }

    String getText() {
        return text(getInt());
    }

    /** Reads a string that ends with a zero byte, from a field of {@code size} bytes. */
    String getField(int size) {
        String text = text(size);
        int end = text.indexOf('\0');
        return end < 0 ? text : text.substring(0, end);
    }

    SiUnit getUnit() {
        return SiUnit.of(bytes(EXPONENTS), getDouble(), getText());
    }

    private String text(int size) {
        return new String(bytes(size), StandardCharsets.UTF_8);
    }

    private byte[] bytes(int size) {
        if (size < 0) {
            throw new IndexOutOfBoundsException("a size of " + size);
        }
        byte[] bytes = memory.asSlice(at, size).toArray(JAVA_BYTE);
        at += size;
        return bytes;
    }
}
