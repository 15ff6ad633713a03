// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import java.lang.foreign.MemorySegment;
import java.lang.invoke.VarHandle;

/**
 * A number in shared memory (a futex). One process waits until another process changes the number.
 * Only one thread per process may use it.
 */
public final class SharedWord {
    private static final long FUTEX_WAIT = 0;
    private static final long FUTEX_WAKE = 1;
    private static final VarHandle INT = JAVA_INT.varHandle();

    private final MemorySegment word;
    private final MemorySegment timeout;

    /**
     * @param word four aligned bytes of shared memory
     * @param timeout 16 aligned bytes for the private use of this object
     */
    public SharedWord(MemorySegment word, MemorySegment timeout) {
        this.word = word;
        this.timeout = timeout;
    }

    /**
     * Returns the number. Everything that the other process wrote before it set the number is then
     * visible.
     */
    public int get() {
        return (int) INT.getAcquire(word, 0L);
    }

    /** Sets the number, and wakes the process that waits. */
    public void announce(int value) {
        INT.setRelease(word, 0L, value);
        Posix.futex(word, FUTEX_WAKE, 1, MemorySegment.NULL);
    }

    /**
     * Waits until the number differs from {@code seen}. Returns at once if it already differs.
     * Otherwise sleeps until the other process announces a number, or {@code nanos} have passed.
     */
    public void await(int seen, long nanos) {
        if (get() == seen) {
            timeout.set(JAVA_LONG, 0, nanos / 1_000_000_000L);
            timeout.set(JAVA_LONG, Long.BYTES, nanos % 1_000_000_000L);
            Posix.futex(word, FUTEX_WAIT, Integer.toUnsignedLong(seen), timeout);
        }
    }
}
