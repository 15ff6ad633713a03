// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;

/**
 * Zeroed memory with a file descriptor. Another process can map the same bytes through {@code
 * /proc/PID/fd/DESCRIPTOR}, or by inheriting the descriptor. Its size never changes. Works on Linux
 * only.
 */
public final class SharedMemory implements AutoCloseable {
    private static final int MFD_CLOEXEC = 1;
    private static final int MFD_ALLOW_SEALING = 2;
    private static final int F_ADD_SEALS = 1033;

    /**
     * Seals of the memory. They ensure that its size cannot change and that the seals cannot be
     * removed.
     */
    private static final int SEALS = 1 | 2 | 4;

    private static final int PROT_READ_WRITE = 1 | 2;
    private static final int MAP_SHARED = 1;
    private static final int ENOMEM = 12;
    private static final int ENFILE = 23;
    private static final int EMFILE = 24;
    private static final int EFBIG = 27;

    private final Arena arena = Arena.ofShared();
    private final int descriptor;
    private final MemorySegment segment;
    private boolean closed;

    /**
     * Reserves memory; a page occupies memory only after it was written.
     *
     * @param name name that appears in /proc, at most 249 bytes
     * @throws IllegalStateException if the system refuses
     */
    public SharedMemory(String name, long bytes) {
        if (bytes <= 0) {
            throw new IllegalArgumentException(
                    "shared memory '" + name + "': " + bytes + " bytes, expected at least 1");
        }
        descriptor =
                check(
                        name,
                        "memfd_create",
                        Posix.memfdCreate(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
        try {
            check(name, "ftruncate to " + bytes, Posix.ftruncate(descriptor, bytes));
            check(name, "sealing", Posix.fcntl(descriptor, F_ADD_SEALS, SEALS));
            segment = map(name, bytes);
        } catch (RuntimeException e) {
            Posix.close(descriptor);
            throw e;
        }
    }

    /** Returns the memory, page-aligned; valid until close. */
    public MemorySegment segment() {
        return segment;
    }

    /** Returns the descriptor in this process. */
    public int descriptor() {
        return descriptor;
    }

    /** Unmaps the memory in this process; mappings of other processes stay valid. Idempotent. */
    @Override
    public void close() {
        if (!closed) {
            closed = true;
            arena.close();
            Posix.close(descriptor);
        }
    }

    // The restricted call is safe, because the kernel has just mapped this number of bytes at this
    // address.
    @SuppressWarnings("restricted")
    private MemorySegment map(String name, long bytes) {
        long address = Posix.mmap(bytes, PROT_READ_WRITE, MAP_SHARED, descriptor, 0);
        check(name, "mmap of " + bytes + " bytes", address);
        return MemorySegment.ofAddress(address).reinterpret(bytes, arena, Posix::munmap);
    }

    private static int check(String name, String what, int result) {
        check(name, what, (long) result);
        return result;
    }

    private static void check(String name, String what, long result) {
        if (result < 0) {
            throw new IllegalStateException(
                    "shared memory '" + name + "': " + what + " failed: " + reason((int) -result));
        }
    }

    /** Returns the message of an errno, with advice for the user. */
    static String reason(int errno) {
        String advice =
                switch (errno) {
                    case EMFILE -> "; raise the limit of open files of the process (ulimit -n)";
                    case ENFILE -> "; raise the limit of open files of the system (fs.file-max)";
                    case EFBIG -> "; raise the limit of the size of files (ulimit -f)";
                    case ENOMEM -> "; make the world smaller, or give the process more memory";
                    default -> "";
                };
        return Posix.words(errno) + " (errno " + errno + ")" + advice;
    }
}
