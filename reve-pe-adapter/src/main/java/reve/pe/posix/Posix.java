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
 * Bindings of C functions, one static method each; if a function fails, the method returns -errno.
 * For any thread.
 */
@SuppressWarnings("restricted") // this class is the only one that looks up functions of the C
// library
final class Posix {
    private static final Linker LINKER = Linker.nativeLinker();
    private static final StructLayout CALL_STATE = Linker.Option.captureStateLayout();
    private static final long ERRNO =
            CALL_STATE.byteOffset(MemoryLayout.PathElement.groupElement("errno"));

    private static final MethodHandle MEMFD_CREATE =
            function("memfd_create", JAVA_INT, ADDRESS, JAVA_INT);
    private static final MethodHandle FTRUNCATE =
            function("ftruncate", JAVA_INT, JAVA_INT, JAVA_LONG);
    private static final MethodHandle MMAP =
            function(
                    "mmap", JAVA_LONG, ADDRESS, JAVA_LONG, JAVA_INT, JAVA_INT, JAVA_INT, JAVA_LONG);
    private static final MethodHandle MUNMAP = function("munmap", JAVA_INT, ADDRESS, JAVA_LONG);
    private static final MethodHandle FCNTL =
            variadic("fcntl", 2, JAVA_INT, JAVA_INT, JAVA_INT, JAVA_INT);
    private static final MethodHandle KILL = function("kill", JAVA_INT, JAVA_INT, JAVA_INT);

    /**
     * The function kill. This handle does not capture errno, so that a call allocates no memory.
     */
    private static final MethodHandle PLAIN_KILL =
            LINKER.downcallHandle(
                    LINKER.defaultLookup().findOrThrow("kill"),
                    FunctionDescriptor.of(JAVA_INT, JAVA_INT, JAVA_INT));

    private static final MethodHandle CLOCK_GETTIME =
            function("clock_gettime", JAVA_INT, JAVA_INT, ADDRESS);
    private static final MethodHandle OPEN = variadic("open", 2, JAVA_INT, ADDRESS, JAVA_INT);
    private static final MethodHandle CLOSE = function("close", JAVA_INT, JAVA_INT);
    private static final MethodHandle STRERROR =
            LINKER.downcallHandle(
                    LINKER.defaultLookup().findOrThrow("strerror"),
                    FunctionDescriptor.of(ADDRESS, JAVA_INT));
    private static final long LONGEST_WORDS = 256;

    private Posix() {}

    /** Returns the descriptor of new memory that no file backs. */
    static int memfdCreate(String name, int flags) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno(
                    (int) MEMFD_CREATE.invokeExact(state, call.allocateFrom(name), flags), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Sets the size; returns 0. */
    static int ftruncate(int descriptor, long bytes) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) FTRUNCATE.invokeExact(state, descriptor, bytes), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns the address of the new mapping, which the kernel chooses. */
    static long mmap(long bytes, int protection, int flags, int descriptor, long offset) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            long address =
                    (long)
                            MMAP.invokeExact(
                                    state,
                                    MemorySegment.NULL,
                                    bytes,
                                    protection,
                                    flags,
                                    descriptor,
                                    offset);
            return address == -1 ? -state.get(JAVA_INT, ERRNO) : address;
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Unmaps the memory; returns 0. */
    static int munmap(MemorySegment mapping) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) MUNMAP.invokeExact(state, mapping, mapping.byteSize()), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns the descriptor of an existing file. */
    static int open(String path, int flags) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) OPEN.invokeExact(state, call.allocateFrom(path), flags), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Closes the descriptor; returns 0. */
    static int close(int descriptor) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) CLOSE.invokeExact(state, descriptor), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns the result of the command, which has one number as its argument. */
    static int fcntl(int descriptor, int command, int argument) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) FCNTL.invokeExact(state, descriptor, command, argument), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Sends the signal; returns 0. A negative id addresses a process group. */
    static int kill(int process, int signal) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            return orErrno((int) KILL.invokeExact(state, process, signal), state);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns whether the process exists. */
    static boolean exists(int process) {
        try {
            return (int) PLAIN_KILL.invokeExact(process, 0) == 0;
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns the time of a clock [ns]. */
    static long clockNanos(int clock) {
        try (Arena call = Arena.ofConfined()) {
            MemorySegment state = call.allocate(CALL_STATE);
            MemorySegment time = call.allocate(2 * Long.BYTES, Long.BYTES);
            int result = orErrno((int) CLOCK_GETTIME.invokeExact(state, clock, time), state);
            return result < 0
                    ? result
                    : time.getAtIndex(JAVA_LONG, 0) * 1_000_000_000L
                            + time.getAtIndex(JAVA_LONG, 1);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    /** Returns the system's message for an errno. */
    static String words(int errno) {
        try {
            return ((MemorySegment) STRERROR.invokeExact(errno))
                    .reinterpret(LONGEST_WORDS)
                    .getString(0);
        } catch (Throwable t) {
            throw unexpected(t);
        }
    }

    private static int orErrno(int result, MemorySegment state) {
        return result == -1 ? -state.get(JAVA_INT, ERRNO) : result;
    }

    private static MethodHandle function(
            String name, MemoryLayout result, MemoryLayout... arguments) {
        return LINKER.downcallHandle(
                LINKER.defaultLookup().findOrThrow(name),
                FunctionDescriptor.of(result, arguments),
                Linker.Option.captureCallState("errno"));
    }

    private static MethodHandle variadic(
            String name, int fixed, MemoryLayout result, MemoryLayout... arguments) {
        return LINKER.downcallHandle(
                LINKER.defaultLookup().findOrThrow(name),
                FunctionDescriptor.of(result, arguments),
                Linker.Option.captureCallState("errno"),
                Linker.Option.firstVariadicArg(fixed));
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
