// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import java.io.IOException;
import java.lang.foreign.MemorySegment;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * A child process that is the leader of a process group of its own. Works on Linux only. For any
 * thread.
 */
public final class ProcessGroup {
    private static final int SIGKILL = 9;
    private static final int SIGCONT = 18;
    private static final int CPUCLOCK_SCHED = 2;

    private final int leader;
    private final MemorySegment leaderAddress;
    private final Path status;

    /**
     * @param leader process id of the child, which is also the id of its group
     */
    public ProcessGroup(long leader) {
        this.leader = Math.toIntExact(leader);
        this.leaderAddress = MemorySegment.ofAddress(leader);
        this.status = Path.of("/proc/" + leader + "/stat");
    }

    /**
     * Kills the processes of the group. Processes that left the group continue. Nothing happens if
     * the leader has not created the group yet.
     */
    public void kill() {
        Posix.kill(-leader, SIGKILL);
    }

    /**
     * Returns whether the leader exists. Returns false at the latest when {@link Process} reports
     * the end of the leader.
     */
    public boolean isAlive() {
        return Posix.exists(leaderAddress);
    }

    /** Returns the processor time of all threads of the leader [ns]; negative after its end. */
    public long cpuNanos() {
        return Posix.clockNanos((~leader << 3) | CPUCLOCK_SCHED);
    }

    /** The state of the main thread of a process. */
    public enum State {
        /** State of a thread that sleeps until an event occurs. */
        SLEEPS,
        /** State of a thread that was stopped by a signal. */
        STOPPED,
        /**
         * State of a thread that waits for a disk, for memory that was swapped out, or for a child
         * of {@code vfork}.
         */
        WAITS_FOR_DISK,
        /** State of a thread that runs, waits for a processor, or has ended. */
        OTHER
    }

    /** Returns the state of the leader's main thread. */
    public State state() {
        try {
            String text = Files.readString(status);
            int state = text.lastIndexOf(')') + 2;
            return switch (state < text.length() ? text.charAt(state) : ' ') {
                case 'S' -> State.SLEEPS;
                case 'T', 't' -> State.STOPPED;
                case 'D' -> State.WAITS_FOR_DISK;
                default -> State.OTHER;
            };
        } catch (IOException ended) {
            return State.OTHER;
        }
    }

    /** Lets stopped processes of the group continue. */
    public void proceed() {
        Posix.kill(-leader, SIGCONT);
    }
}
