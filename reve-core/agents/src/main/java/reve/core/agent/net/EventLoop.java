// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import java.io.IOException;
import java.nio.channels.SelectableChannel;
import java.nio.channels.SelectionKey;
import java.nio.channels.Selector;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;
import java.util.concurrent.locks.ReentrantLock;
import java.util.function.BooleanSupplier;

/**
 * The event loop of a server. It reads, processes and writes the messages of all agents. One thread
 * at a time runs the loop. This is the loop's own thread, or a world's thread while the world waits
 * for agents. The loop waits for sockets, other threads and the clock, but never for a single
 * client.
 */
public final class EventLoop {

    private static final long NAP_NANOS = 5_000_000;

    /**
     * Maximum busy-wait of a world's thread before it blocks in {@code select} [ns]. A busy-wait
     * avoids the wake-up of a thread on an idle processor, which takes longer than most requests.
     * The thread waits in this way only if the last event arrived within this time. The value is 0
     * on a machine with one processor, where a busy-wait would take time from the agents.
     */
    private static final long AWAKE_NANOS =
            Runtime.getRuntime().availableProcessors() > 1 ? 100_000 : 0;

    /** Handles the operations of one channel. */
    interface Handler {
        /**
         * Called when the channel is ready for an operation that the key selects, such as a read.
         */
        void ready(SelectionKey key);
    }

    /** Work that the loop does in each turn, after the channels and the tasks. */
    public interface Work {
        /** Returns whether there is work that can be done now. */
        boolean isWaiting();

        /** Does the work. */
        void run();

        /** Checks time limits. Called periodically. */
        void checkDeadlines(long nowNanos);
    }

    private final Selector selector;
    private final RateLimitedLog log;
    private final Work work;
    private final long checkNanos;
    private final Thread thread;

    /** The lock that a thread holds while it runs the loop. */
    private final ReentrantLock duty = new ReentrantLock();

    private final Queue<Runnable> tasks = new ConcurrentLinkedQueue<>();
    private long checkedNanos = System.nanoTime();

    /** True if the last check of deadlines was left out. */
    private boolean leftOut;

    /**
     * True if the last event arrived within {@link #AWAKE_NANOS}, so that a busy-wait is
     * worthwhile.
     */
    private boolean quick;

    /** True if another thread has added work since this turn began. */
    private volatile boolean woken;

    private volatile boolean selecting;

    /**
     * True while another thread runs the loop from time to time. The loop's own thread then only
     * checks whether the other thread still runs the loop.
     */
    private volatile boolean taken;

    private volatile boolean stopped;

    /**
     * @param checkNanos time between two checks of deadlines
     */
    public EventLoop(RateLimitedLog log, Work work, long checkNanos) throws IOException {
        this.log = log;
        this.work = work;
        this.checkNanos = checkNanos;
        this.selector = Selector.open();
        this.thread = Thread.ofPlatform().name("agents").daemon().unstarted(this::run);
    }

    // ---- methods for any thread ----

    /** Starts the loop's own thread. */
    public void start() {
        thread.start();
    }

    /** Stops the loop after the current turn. */
    public void stop() {
        stopped = true;
        wake();
    }

    /**
     * Waits for the loop's thread to end.
     *
     * @return false if it has not ended within the time
     */
    public boolean join(long millis) throws InterruptedException {
        thread.join(millis);
        return !thread.isAlive();
    }

    /** Returns whether the loop's own thread runs. */
    public boolean isRunning() {
        return thread.isAlive();
    }

    /** Runs a task on the thread that runs the loop. */
    public void later(Runnable task) {
        tasks.add(task);
        wake();
    }

    /** Wakes the loop, so that it looks for work. */
    public void wake() {
        if (duty.isHeldByCurrentThread()) {
            return; // the calling thread runs the loop, which looks for work before it blocks
        }
        woken = true;
        if (selecting) {
            selector.wakeup();
        }
    }

    // ---- methods for the loop's thread ----

    /** Registers a channel; the handler is called when the channel is ready. */
    SelectionKey register(SelectableChannel channel, int operations, Handler handler)
            throws IOException {
        channel.configureBlocking(false);
        return channel.register(selector, operations, handler);
    }

    /**
     * Runs the loop on the calling thread instead of the loop's own thread. Returns when {@code
     * enough} returns true or the time has passed. A world's thread that calls this method reads
     * the last agent's request itself, so no switch between threads delays the world. The loop's
     * own thread takes over if this method is not called again for a while.
     */
    public void work(long nanoseconds, BooleanSupplier enough) {
        taken = true;
        if (!duty.tryLock()) {
            selector.wakeup();
            duty.lock();
        }
        try {
            woken = false;
            if (!enough.getAsBoolean()) {
                turn(nanoseconds, quick ? AWAKE_NANOS : 0);
            }
        } finally {
            duty.unlock();
        }
    }

    private void run() {
        while (!stopped) {
            // A world's thread that waits for the lock has priority. Otherwise, this thread could
            // take the lock again before the world's thread gets a processor.
            if (taken || duty.hasQueuedThreads() || !duty.tryLock()) {
                taken = false;
                LockSupport.parkNanos(NAP_NANOS);
                continue;
            }
            try {
                woken = false;
                turn(checkNanos, 0);
            } finally {
                duty.unlock();
            }
        }
        try (selector) {
            for (SelectionKey key : selector.keys()) {
                key.channel().close();
            }
        } catch (IOException e) {
            log.error("letting go of connections failed", e);
        }
    }

    /**
     * Runs one turn of the loop: processes the available work, then waits for more. This order
     * ensures that no available work is left when another thread takes over the loop.
     */
    private void turn(long mostNanos, long awakeNanos) {
        try {
            // Only the tasks present now are run. Tasks that they add run in the next turn, so this
            // loop always ends.
            for (int count = tasks.size(); count > 0 && tasks.poll() instanceof Runnable task; ) {
                task.run();
                count--;
            }
            work.run();
            long now = System.nanoTime();
            if (now - checkedNanos >= checkNanos) {
                checkDeadlines(now);
            }
            select(Math.min(mostNanos, checkedNanos + checkNanos - now), now + awakeNanos);
            quick = System.nanoTime() - now < AWAKE_NANOS;
        } catch (Throwable e) { // an error caused by one client must not stop the others
            log.error("serving agents failed", e);
        }
    }

    /**
     * Checks deadlines. If this thread had to wait, for example on a busy machine, it first reads
     * what clients sent meanwhile: one check is left out.
     */
    private void checkDeadlines(long now) {
        boolean waited = now - checkedNanos >= 2 * checkNanos;
        checkedNanos = now;
        leftOut = waited && !leftOut;
        if (!leftOut) {
            work.checkDeadlines(now);
        }
    }

    private void select(long nanoseconds, long awakeUntilNanos) throws IOException {
        selecting = true; // a thread that adds work must now wake the selector
        if (!findsSoon(awakeUntilNanos)) {
            if (hasWork()) {
                selector.selectNow(EventLoop::handle);
            } else {
                selector.select(EventLoop::handle, TimeUnit.NANOSECONDS.toMillis(nanoseconds) + 1);
            }
        }
        selecting = false;
    }

    /**
     * Polls the sockets in a busy-wait.
     *
     * @return true if a socket was ready before other work arrived
     */
    private boolean findsSoon(long awakeUntilNanos) throws IOException {
        while (!hasWork() && System.nanoTime() - awakeUntilNanos < 0) {
            if (selector.selectNow(EventLoop::handle) > 0) {
                return true;
            }
            Thread.onSpinWait();
        }
        return false;
    }

    private boolean hasWork() {
        return woken || !tasks.isEmpty() || work.isWaiting() || stopped;
    }

    private static void handle(SelectionKey key) {
        ((Handler) key.attachment()).ready(key);
    }
}
