// SPDX-License-Identifier: Apache-2.0
package reve.pe.posix;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;

/** A child process that leads a process group of its own. Linux only; any thread. */
public final class ProcessGroup {
    private static final int SIGKILL = 9;
    private static final int CPUCLOCK_SCHED = 2;

    /** Not: R, D (waits for a disk or for memory), Z and X (ended). */
    private static final String IDLE_STATES = "STt";

    private final int leader;
    private final Path status;

    /**
     * @param leader id of the process
     */
    public ProcessGroup(long leader) {
        this.leader = Math.toIntExact(leader);
        this.status = Path.of("/proc/" + leader + "/stat");
    }

    /** Kills the processes of the group; those that left it, or made none yet, stay. */
    public void kill() {
        Posix.kill(-leader, SIGKILL);
    }

    /** Returns whether the leader exists. False as soon as its end can be observed elsewhere. */
    public boolean isAlive() {
        return Posix.exists(leader);
    }

    /** Returns the processor time of all threads of the process [ns]; negative after its end. */
    public long cpuNanos() {
        return Posix.clockNanos((~leader << 3) | CPUCLOCK_SCHED);
    }

    /** Returns whether the main thread sleeps by its own will, or was stopped. */
    public boolean isIdle() {
        try {
            String text = Files.readString(status);
            int state = text.lastIndexOf(')') + 2;
            return state < text.length() && IDLE_STATES.indexOf(text.charAt(state)) >= 0;
        } catch (IOException ended) {
            return false;
        }
    }
}
