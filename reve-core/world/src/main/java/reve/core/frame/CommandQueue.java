// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.ArrayList;
import java.util.Collection;
import java.util.Comparator;
import java.util.Iterator;
import java.util.List;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.function.LongSupplier;

/**
 * The queue of commands from other threads. The phase INTAKE takes the queued commands into the
 * frame. The phase ACT executes them in order of origin and sequence, so the order of arrival
 * within a frame has no effect.
 *
 * <p>Prompt commands may be executed before the frame. Costly commands share a time limit in each
 * frame, but at least one of them is executed. The queue is bounded. It uses no locks.
 */
public final class CommandQueue {

    private static final Comparator<Command> ORDER =
            Comparator.comparing(Command::origin).thenComparingLong(Command::sequence);

    /**
     * Time limit for the costly commands of one frame [ns]. It is checked before each command, so
     * the last command may exceed it.
     */
    private static final long COSTLY_NANOS = 25_000_000;

    private final int capacity;
    private final LongSupplier nanoTime;
    private final Queue<Command> arrived = new ConcurrentLinkedQueue<>();
    private final AtomicInteger waiting = new AtomicInteger();
    private final List<Command> taken = new ArrayList<>();

    /** Commands that must wait for the next frame. They count towards the capacity. */
    private final List<Command> postponed = new ArrayList<>();

    private final FaultLog faults = new FaultLog();

    /**
     * @param capacity maximum number of commands that wait for the next frame
     */
    public CommandQueue(int capacity) {
        this(capacity, System::nanoTime);
    }

    /**
     * @param nanoTime clock that measures costly commands [ns]; its times determine in which frame
     *     a costly command is executed
     */
    CommandQueue(int capacity, LongSupplier nanoTime) {
        if (capacity < 1) {
            throw new IllegalArgumentException(
                    "command queue of capacity " + capacity + ", expected 1 or more");
        }
        this.capacity = capacity;
        this.nanoTime = nanoTime;
    }

    /** Subscribes the queue to the phases INTAKE and ACT of the frames. */
    public void subscribeTo(FrameBus bus) {
        bus.subscribe(FramePhase.INTAKE, "command queue", this::take);
        bus.subscribe(FramePhase.ACT, "command queue", this::execute);
    }

    /**
     * Queues a command for the next frame. For any thread.
     *
     * @return false if the queue is full
     */
    public boolean offer(Command command) {
        if (waiting.incrementAndGet() > capacity) {
            waiting.decrementAndGet();
            return false;
        }
        arrived.add(command);
        return true;
    }

    /**
     * Executes the queued prompt commands ({@link Command#isPrompt}) between two frames. Costly
     * commands that exceed the time limit stay in the queue.
     *
     * @return true if prompt commands remain
     */
    boolean executePrompt(FrameEvent event) {
        takePrompt(arrived);
        takePrompt(postponed);
        taken.sort(ORDER);
        execute(event);
        return postponed.stream().anyMatch(Command::isPrompt);
    }

    private void takePrompt(Collection<Command> queued) {
        for (Iterator<Command> all = queued.iterator(); all.hasNext(); ) {
            Command command = all.next();
            if (command.isPrompt()) {
                all.remove();
                waiting.decrementAndGet();
                taken.add(command);
            }
        }
    }

    private void take(FrameEvent event) {
        // Commands that arrive during this loop belong to the next frame. A fast sender could
        // otherwise keep the loop running.
        for (int i = waiting.get(); i > 0; i--) {
            Command command = arrived.poll();
            if (command == null) {
                break;
            }
            waiting.decrementAndGet();
            taken.add(command);
        }
        if (!postponed.isEmpty()) {
            // The check avoids that addAll allocates memory for an empty list.
            waiting.addAndGet(-postponed.size());
            taken.addAll(postponed);
            postponed.clear();
        }
        taken.sort(ORDER);
    }

    private void execute(FrameEvent event) {
        long costly = 0;
        for (int i = 0; i < taken.size(); i++) {
            Command command = taken.get(i);
            try {
                if (isOfWaiting(command.origin())
                        || command.mustWait(event)
                        || command.isCostly() && costly >= COSTLY_NANOS) {
                    postponed.add(command);
                    waiting.incrementAndGet();
                    continue;
                }
                if (command.isCostly()) {
                    long start = nanoTime.getAsLong();
                    command.execute(event.world(), event);
                    costly += nanoTime.getAsLong() - start;
                } else {
                    command.execute(event.world(), event);
                }
            } catch (Exception | LinkageError | StackOverflowError e) {
                faults.report(event, "command of " + command.origin(), e);
            }
        }
        taken.clear();
    }

    /**
     * Returns whether an earlier command of this origin was postponed. The last postponed command
     * is sufficient for this check, because commands are executed in order of origin.
     */
    private boolean isOfWaiting(String origin) {
        return !postponed.isEmpty() && postponed.getLast().origin().equals(origin);
    }
}
