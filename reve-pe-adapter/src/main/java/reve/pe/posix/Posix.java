// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import static java.lang.foreign.ValueLayout.ADDRESS;
import static java.lang.foreign.ValueLayout.JAVA_INT;
import static java.lang.foreign.ValueLayout.JAVA_LONG;

import java.lang.foreign.Arena;
import java.lang.foreign.FunctionDescriptor;
import java.lang.foreign.Linker;
import java.lang.foreign.MemoryLayout;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.StructLayout;
import java.lang.invoke.MethodHandle;

/**
 * Bindings of C functions, one static method each. A method returns -errno if its function fails.
 * For any thread.
 */
// The warning is suppressed, because only this class looks up functions of the C library.
@SuppressWarnings("restricted")
final class Posix {
    private static final Linker LINKER = Linker.nativeLinker();
    private static final StructLayout CALL_STATE = Linker.Option.captureStateLayout();
    private static final long ERRNO =
            CALL_STATE.byteOffset(MemoryLayout.PathElement.groupElement("errno"));

    /**
     * Calls the C function at the address that is the first argument, and captures errno in the
     * second. All functions of this class share this handle, because each further signature costs
     * 10 ms at every start. The calling conventions of Linux allow it on x86-64 and aarch64: each
     * argument occupies a register, of which a function reads only what it declares.
     */
    private static final MethodHandle CALL =
            LINKER.downcallHandle(
                    FunctionDescriptor.of(
                            JAVA_LONG, JAVA_LONG, JAVA_LONG, JAVA_LONG, JAVA_LONG, JAVA_LONG,
                            JAVA_LONG),
                    Linker.Option.captureCallState("errno"));

    /**
     * Calls the function {@code syscall} without errno. Unlike {@link #CALL} it allocates no memory
     * before the code is optimised.
     */
    private static final MethodHandle SYSCALL =
            LINKER.downcallHandle(
                    function("syscall"),
                    FunctionDescriptor.of(
                            JAVA_LONG, JAVA_LONG, ADDRESS, JAVA_LONG, JAVA_LONG, ADDRESS, ADDRESS,
                            JAVA_LONG),
                    Linker.Option.firstVariadicArg(1));

    private static final boolean AARCH64 = System.getProperty("os.arch").equals("aarch64");
    private static final long SYS_FUTEX = AARCH64 ? 98 : 202;
    private static final long SYS_KILL = AARCH64 ? 129 : 62;

    /** Receives the errno of calls whose errno is not needed. Any thread may write it. */
    private static final MemorySegment IGNORED_STATE = Arena.global().allocate(CALL_STATE);

    private static final MemorySegment MEMFD_CREATE = function("memfd_create");
    private static final MemorySegment FTRUNCATE = function("ftruncate");
    private static final MemorySegment MMAP = function("mmap");
    private static final MemorySegment MUNMAP = function("munmap");
    private static final MemorySegment FCNTL = function("fcntl");
    private static final MemorySegment KILL = function("kill");
    private static final MemorySegment CLOCK_GETTIME = function("clock_gettime");
    private static final MemorySegment OPEN = function("open");
    private static final MemorySegment CLOSE = function("close");
    private static final MemorySegment STRERROR = function("strerror");
    private static final long LONGEST_WORDS = 256;

    private Posix() {}

    /** Returns the descriptor of new memory that no file backs. */
    static int memfdCreate(String name, int flags) {
        try (Arena call = Arena.ofConfined()) {
            return call(MEMFD_CREATE, call.allocateFrom(name).address(), flags);
        }
    }

    /** Sets the size; returns 0. */
    static int ftruncate(int descriptor, long bytes) {
        return call(FTRUNCATE, descriptor, bytes);
    }

    /** Returns the address of the new mapping, which the kernel chooses. */
    static long mmap(long bytes, int protection, int flags, int descriptor, long offset) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            long address = call(MMAP, state, 0, bytes, protection, flags, descriptor, offset);
            return address == -1 ? -state.get(JAVA_INT, ERRNO) : address;
        }
    }

    /** Unmaps the memory; returns 0. */
    static int munmap(MemorySegment mapping) {
        return call(MUNMAP, mapping.address(), mapping.byteSize());
    }

    /** Returns the descriptor of an existing file. */
    static int open(String path, int flags) {
        try (Arena call = Arena.ofConfined()) {
            return call(OPEN, call.allocateFrom(path).address(), flags);
        }
    }

    /** Closes the descriptor; returns 0. */
    static int close(int descriptor) {
        return call(CLOSE, descriptor, 0);
    }

    /** Returns the result of the command, which has one number as its argument. */
    static int fcntl(int descriptor, int command, int argument) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) call(FCNTL, state, descriptor, command, argument, 0, 0, 0), state);
        }
    }

    /** Sends the signal; returns 0. A negative id addresses a process group. */
    static int kill(int process, int signal) {
        return call(KILL, process, signal);
    }

    /**
     * Returns whether the process exists. Allocates no memory.
     *
     * @param process the process id as an address, because {@link #SYSCALL} receives an address
     */
    static boolean exists(MemorySegment process) {
        return syscall(SYS_KILL, process, 0, 0, MemorySegment.NULL) == 0;
    }

    /** Waits for a futex, or wakes the threads that wait for it. Allocates no memory. */
    static void futex(MemorySegment word, long operation, long value, MemorySegment timeout) {
        syscall(SYS_FUTEX, word, operation, value, timeout);
    }

    private static long syscall(
            long number, MemorySegment first, long second, long third, MemorySegment fourth) {
        try {
            return (long)
                    SYSCALL.invokeExact(
                            number, first, second, third, fourth, MemorySegment.NULL, 0L);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns the time of a clock [ns]. */
    static long clockNanos(int clock) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment time = call.allocate(2 * Long.BYTES, Long.BYTES);
            int result = call(CLOCK_GETTIME, clock, time.address());
            return result < 0
                    ? result
                    : time.getAtIndex(JAVA_LONG, 0) * 1_000_000_000L
                            + time.getAtIndex(JAVA_LONG, 1);
        }
    }

    /** Returns the system's message for an errno. */
    static String words(int errno) {
        long address = call(STRERROR, IGNORED_STATE, errno, 0, 0, 0, 0, 0);
        return MemorySegment.ofAddress(address).reinterpret(LONGEST_WORDS).getString(0);
    }

    /** Calls a function of two arguments that returns an int, or -1 and sets errno. */
    private static int call(MemorySegment function, long first, long second) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) call(function, state, first, second, 0, 0, 0, 0), state);
        }
    }

    private static long call(
            MemorySegment function,
            MemorySegment state,
            long first,
            long second,
            long third,
            long fourth,
            long fifth,
            long sixth) {
        try {
            return (long)
                    CALL.invokeExact(function, state, first, second, third, fourth, fifth, sixth);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    private static int orErrno(int result, MemorySegment state) {
        return result == -1 ? -state.get(JAVA_INT, ERRNO) : result;
    }

    private static MemorySegment function(String name) {
        return LINKER.defaultLookup().findOrThrow(name);
    }

    static RuntimeException unexpected(Throwable t) {
        if (t instanceof RuntimeException exception) {
            return exception;
        }
        if (t instanceof Error error) {
            throw error;
        }
        throw new AssertionError("a downcall threw a checked exception", t);
    }
}
