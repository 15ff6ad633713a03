// SPDX-License-Identifier: Apache-2.0
package reve.pe.vesper;

import org.jspecify.annotations.Nullable;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.nio.charset.StandardCharsets;

/** Conversion of strings for C: UTF-8, NUL-terminated. */
final class VesperStrings {
    private VesperStrings() {}

    /** Copies a string that C returned by address; empty for null. */
    // The restricted call is safe, because C guarantees a terminated string. Its length is unknown.
    @SuppressWarnings("restricted")
    static String read(MemorySegment address) {
        return address.address() == 0
                ? ""
                : address.reinterpret(Long.MAX_VALUE).getString(0, StandardCharsets.UTF_8);
    }

    /** Copies a string that C stored by address in a struct; empty for null. */
    static String readAt(MemorySegment struct, long offset) {
        return read(struct.get(ValueLayout.ADDRESS, offset));
    }

    /** Copies a string from a fixed array inside a struct, terminated or not. */
    static String readInline(MemorySegment struct, long offset, long size) {
        byte[] bytes = struct.asSlice(offset, size).toArray(ValueLayout.JAVA_BYTE);
        int length = 0;
        while (length < bytes.length && bytes[length] != 0) {
            length++;
        }
        return new String(bytes, 0, length, StandardCharsets.UTF_8);
    }

    /** Returns the string in native memory, or a null pointer. */
    static MemorySegment write(Arena arena, @Nullable String text) {
        return text == null ? MemorySegment.NULL : arena.allocateFrom(text, StandardCharsets.UTF_8);
    }

    /**
     * Writes a string into a fixed array inside a struct, truncated if necessary, always
     * terminated.
     */
    static void writeInline(MemorySegment struct, long offset, long size, String text) {
        byte[] bytes = text.getBytes(StandardCharsets.UTF_8);
        int length = (int) Math.min(bytes.length, size - 1);
        while (length > 0 && length < bytes.length && (bytes[length] & 0xC0) == 0x80) {
            length--; // the text must not end inside a character
        }
        MemorySegment.copy(bytes, 0, struct, ValueLayout.JAVA_BYTE, offset, length);
        struct.set(ValueLayout.JAVA_BYTE, offset + length, (byte) 0);
    }
}
