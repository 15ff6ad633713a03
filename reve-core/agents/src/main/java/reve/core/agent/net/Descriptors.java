// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import com.sun.management.UnixOperatingSystemMXBean;

import java.io.IOException;
import java.lang.management.ManagementFactory;
import java.util.concurrent.atomic.AtomicLong;
import java.util.function.LongSupplier;

/**
 * Counter of the file descriptors of this process that connections may still take. A reserve
 * remains for stores, recordings, the audit record and laws, so that clients cannot make these
 * fail. For any thread.
 */
public final class Descriptors {

    /** Number of descriptors that connections never take. */
    static final int RESERVE = 64;

    private final LongSupplier limit;
    private final LongSupplier open;

    /**
     * Number of further possible connections: the number at the last count, minus the connections
     * accepted since then.
     */
    private final AtomicLong room = new AtomicLong();

    /**
     * @param limit returns the maximum number of open descriptors of the process
     * @param open returns the number of its open descriptors
     */
    Descriptors(LongSupplier limit, LongSupplier open) {
        this.limit = limit;
        this.open = open;
        count();
    }

    /**
     * Returns the descriptors of this process.
     *
     * @throws IOException if the limit of the process leaves none for connections
     */
    public static Descriptors ofProcess() throws IOException {
        var system = (UnixOperatingSystemMXBean) ManagementFactory.getOperatingSystemMXBean();
        var descriptors =
                new Descriptors(
                        system::getMaxFileDescriptorCount, system::getOpenFileDescriptorCount);
        if (descriptors.room() < 1) {
            throw new IOException(
                    "no connection could be accepted: the process may open "
                            + descriptors.limit()
                            + " files, "
                            + system.getOpenFileDescriptorCount()
                            + " are open, and "
                            + RESERVE
                            + " are reserved for stores and records; raise the limit:"
                            + " ulimit -n 4096");
        }
        return descriptors;
    }

    /** Returns the maximum number of open descriptors of the process. */
    long limit() {
        return limit.getAsLong();
    }

    /** Returns the number of further connections that are possible. */
    public long room() {
        return room.get();
    }

    /**
     * Updates the number of possible connections from the number of open descriptors, because other
     * parts of the process also open files.
     */
    void count() {
        try {
            room.set(limit.getAsLong() - open.getAsLong() - RESERVE);
        } catch (InternalError none) {
            // Counting takes a descriptor, and no descriptor is left.
            room.set(0);
        }
    }

    /** Records that a connection was accepted. */
    void take() {
        room.decrementAndGet();
    }

    /**
     * Takes descriptors for connections whose end is not reported to {@link #give}. The next {@link
     * #count} finds that they are free again.
     *
     * @return false, without effect, if fewer than {@code count} are left
     */
    public boolean takeIfLeft(int count) {
        long left = room.get();
        while (left >= count) {
            if (room.compareAndSet(left, left - count)) {
                return true;
            }
            left = room.get();
        }
        return false;
    }

    /** Records that a connection has ended. */
    void give() {
        room.incrementAndGet();
    }
}
