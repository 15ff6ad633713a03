// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.ArrayList;
import java.util.Comparator;
import java.util.Iterator;
import java.util.List;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;

/**
 * The way into the world from other threads. INTAKE takes what has arrived into the frame, ACT
 * executes it ordered by origin and sequence, so that the order of arrival within a frame does not
 * matter. Prompt commands may come before their frame. Bounded, and lock-free on both sides.
 */
public final class CommandQueue {

    private static final Comparator<Command> ORDER =
            Comparator.comparing(Command::origin).thenComparingLong(Command::sequence);

    private final int capacity;
    private final Queue<Command> arrived = new ConcurrentLinkedQueue<>();
    private final AtomicInteger waiting = new AtomicInteger();
    private final List<Command> taken = new ArrayList<>();

    /** Those that must wait for the next frame; they count as waiting. */
    private final List<Command> postponed = new ArrayList<>();

    private final FaultLog faults = new FaultLog();

    /**
     * @param capacity most commands that may wait for the next frame
     */
    public CommandQueue(int capacity) {
        if (capacity < 1) {
            throw new IllegalArgumentException(
                    "command queue of capacity " + capacity + ", expected 1 or more");
        }
        this.capacity = capacity;
    }

    /** Makes the queue take part in frames. */
    public void subscribeTo(FrameBus bus) {
        bus.subscribe(FramePhase.INTAKE, "command queue", this::take);
        bus.subscribe(FramePhase.ACT, "command queue", this::execute);
    }

    /** Queues a command for the next frame. Any thread; false if the queue is full. */
    public boolean offer(Command command) {
        if (waiting.incrementAndGet() > capacity) {
            waiting.decrementAndGet();
            return false;
        }
        arrived.add(command);
        return true;
    }

    /** Executes the prompt commands that have arrived; between frames. */
    void executePrompt(FrameEvent event) {
        for (Iterator<Command> all = arrived.iterator(); all.hasNext(); ) {
            Command command = all.next();
            if (command.isPrompt()) {
                all.remove();
                waiting.decrementAndGet();
                taken.add(command);
            }
        }
        taken.sort(ORDER);
        execute(event);
    }

    private void take(FrameEvent event) {
        // What arrives while we take belongs to the next frame, else a fast sender could hold us
        // here.
        for (int i = waiting.get(); i > 0; i--) {
            Command command = arrived.poll();
            if (command == null) {
                break;
            }
            waiting.decrementAndGet();
            taken.add(command);
        }
        if (!postponed.isEmpty()) { // addAll allocates for an empty list, too
            waiting.addAndGet(-postponed.size());
            taken.addAll(postponed);
            postponed.clear();
        }
        taken.sort(ORDER);
    }

    private void execute(FrameEvent event) {
        for (int i = 0; i < taken.size(); i++) {
            Command command = taken.get(i);
            try {
                if (isOfWaiting(command.origin()) || command.mustWait(event)) {
                    postponed.add(command);
                    waiting.incrementAndGet();
                    continue;
                }
                command.execute(event.world(), event);
            } catch (Exception | LinkageError | StackOverflowError e) {
                faults.report(event, "command of " + command.origin(), e);
            }
        }
        taken.clear();
    }

    /** Commands are executed in the order of their origins, so the last one that waits tells. */
    private boolean isOfWaiting(String origin) {
        return !postponed.isEmpty() && postponed.getLast().origin().equals(origin);
    }
}
