// SPDX-License-Identifier: Apache-2.0
package reve.pe.hosted;

import reve.pe.posix.ProcessGroup;

/**
 * The time of a request to a host (an engine's process), as it counts for the time limit of the
 * request. Processor time and idle time count. Time in which the host waits for a processor does
 * not count, because other programs cause it. For one thread.
 */
final class CallTime {
    /** Processor time between two checks below which the host counts as waiting [ns]. */
    private static final long IDLE_NANOS = 50_000;

    /**
     * Time for which a host may wait for a disk in one request [ns]. Additional time counts for the
     * limit, because a disk may never answer. The sum with the longest time limit of a frame is
     * less than 4 s.
     */
    private static final long DISK_NANOS = 500_000_000;

    /**
     * Multiple of the time limit after which a host is ended even if it got no processor. This
     * limit applies to elapsed time.
     */
    private static final int MOST_WALL = 20;

    /**
     * Additional elapsed time for a host that waits for a law in a sandbox [ns]. The host is ended
     * after this time.
     */
    private static final long SANDBOX_NANOS = 500_000_000;

    private final long limitNanos;
    private final long startCpu;
    private long cpu;
    private long idle;
    private long disk;
    private long wall;

    /**
     * @param limitNanos the time limit of the request [ns]
     * @param cpuNanos processor time of the host at the start of the request [ns]
     */
    CallTime(long limitNanos, long cpuNanos) {
        this.limitNanos = limitNanos;
        startCpu = cpuNanos;
        cpu = cpuNanos;
    }

    long limitNanos() {
        return limitNanos;
    }

    /**
     * Counts the time since the last check.
     *
     * @param elapsedNanos wall-clock time since the last check [ns]
     * @param cpuNanos processor time of the host [ns]; negative after its end
     * @return whether the host used the processor; otherwise the state of the host determines the
     *     time that counts
     */
    boolean counts(long elapsedNanos, long cpuNanos) {
        long before = cpu;
        cpu = Math.max(before, cpuNanos);
        wall += elapsedNanos;
        return cpu - before >= IDLE_NANOS;
    }

    /** Counts time in which the host did not use the processor, by the state of the host. */
    void countsWithoutProcessor(long elapsedNanos, ProcessGroup.State state) {
        switch (state) {
            case SLEEPS, STOPPED -> idle += elapsedNanos;
            case WAITS_FOR_DISK -> {
                disk += elapsedNanos;
                if (disk > DISK_NANOS) {
                    idle += elapsedNanos;
                }
            }
            case OTHER -> {
                // No time is counted, because the host waits for a processor or has ended.
            }
        }
    }

    /** Returns the time that counts so far [ns]. */
    long spentNanos() {
        return cpu - startCpu + idle;
    }

    /**
     * Returns whether the host must be ended.
     *
     * @param inSandbox whether a law in a sandbox is running; the host itself ends this law at the
     *     limit
     */
    boolean isLate(boolean inSandbox) {
        long mostWall = MOST_WALL * limitNanos;
        return inSandbox
                ? wall >= mostWall + SANDBOX_NANOS
                : spentNanos() >= limitNanos || wall >= mostWall;
    }
}
