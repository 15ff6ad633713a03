// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.world.ActionRefused;

import java.lang.management.ManagementFactory;
import java.lang.management.MemoryPoolMXBean;
import java.lang.management.MemoryType;
import java.util.function.LongSupplier;

/**
 * Refuses changes while the Java heap is nearly full, because an exhausted heap ends the server
 * with all its worlds. For any thread.
 */
final class HeapRoom {
    /** The limit for the Java heap of this process. */
    static final HeapRoom OF_PROCESS = ofProcess();

    /** Percentage of the heap that reachable objects may use. */
    private static final long MOST = 75;

    /**
     * Growth of the used heap, in percent of its maximum size, after which the next garbage
     * collection is requested.
     */
    private static final long GROWTH = 5;

    /**
     * Time after which a garbage collection is requested even if the heap has not grown, because
     * items may have been removed meanwhile [ns].
     */
    private static final long AGAIN_NANOS = 10_000_000_000L;

    private static final long HUNDRED = 100;
    private static final long MEBIBYTE = 1 << 20;

    private final LongSupplier used;
    private final long max;
    private final Runnable collect;
    private final LongSupplier nanoTime;

    /**
     * Size of the objects that the last garbage collection did not remove [bytes]. The next field
     * is the time of that collection [ns].
     */
    private long reachable;

    private long collected;

    /**
     * @param used returns the number of used bytes, including unreachable objects
     * @param max the maximum number of used bytes
     * @param collect removes unreachable objects
     * @param nanoTime returns the time [ns]
     */
    HeapRoom(LongSupplier used, long max, Runnable collect, LongSupplier nanoTime) {
        this.used = used;
        this.max = max;
        this.collect = collect;
        this.nanoTime = nanoTime;
    }

    private static HeapRoom ofProcess() {
        // Only the memory pool of old objects supports a threshold of usage, so it is found by this
        // property.
        MemoryPoolMXBean old =
                ManagementFactory.getMemoryPoolMXBeans().stream()
                        .filter(MemoryPoolMXBean::isUsageThresholdSupported)
                        .filter(pool -> pool.getType() == MemoryType.HEAP)
                        .findFirst()
                        .orElseThrow();
        long max = old.getUsage().getMax();
        return new HeapRoom(
                () -> old.getUsage().getUsed(),
                max < 0 ? Runtime.getRuntime().maxMemory() : max,
                System::gc,
                System::nanoTime);
    }

    /**
     * Refuses a change if the heap is nearly full.
     *
     * @throws ActionRefused if reachable objects use more than three quarters of the heap
     */
    synchronized void require() throws ActionRefused {
        long now = used.getAsLong();
        if (!isTooMuch(now)) {
            reachable = Math.min(reachable, now);
            return;
        }
        // The used part of the heap includes unreachable objects. Only a garbage collection shows
        // how many bytes are reachable, so this code requests one from time to time.
        if (now - reachable > max / HUNDRED * GROWTH
                || nanoTime.getAsLong() - collected > AGAIN_NANOS) {
            collect.run();
            reachable = used.getAsLong();
            collected = nanoTime.getAsLong();
        }
        if (isTooMuch(reachable)) {
            throw new ActionRefused(
                    "server-full",
                    "the heap of the server has "
                            + reachable / MEBIBYTE
                            + " of "
                            + max / MEBIBYTE
                            + " MiB in use, and changes are refused from "
                            + MOST
                            + " %; remove items or images, or start the server with more memory"
                            + " (REVE_HEAP)");
        }
    }

    private boolean isTooMuch(long bytes) {
        return bytes > max / HUNDRED * MOST;
    }
}
