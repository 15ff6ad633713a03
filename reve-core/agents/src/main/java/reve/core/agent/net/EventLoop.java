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
 * Reads, writes and works for all agents, on one thread at a time: its own, or another that has
 * nothing better to do. It waits for sockets, for other threads and for the clock, never for a
 * client.
 */
public final class EventLoop {

    private static final long NAP_NANOS = 5_000_000;

    /**
     * As long as this a world's thread looks for what comes before it sleeps, if what it waited for
     * last came within that time: to wake a thread on an idle processor takes longer than most of
     * what agents do. With one processor that would be the agents' time.
     */
    private static final long AWAKE_NANOS =
            Runtime.getRuntime().availableProcessors() > 1 ? 100_000 : 0;

    /** Something that a channel brings work for. */
    interface Handler {
        /** The channel is ready for an operation that the key is interested in. */
        void ready(SelectionKey key);
    }

    /** What is done in every turn, after what channels and tasks brought. */
    public interface Work {
        /** True if there is something to do at once. */
        boolean isWaiting();

        /** Does what there is to do. */
        void run();

        /** Called every now and then. */
        void checkDeadlines(long nowNanos);
    }

    private final Selector selector;
    private final RateLimitedLog log;
    private final Work work;
    private final long checkNanos;
    private final Thread thread;

    /** Held by the thread that works. */
    private final ReentrantLock duty = new ReentrantLock();

    private final Queue<Runnable> tasks = new ConcurrentLinkedQueue<>();
    private long checkedNanos = System.nanoTime();

    /** What was waited for last was there within {@link #AWAKE_NANOS}. */
    private boolean quick;

    /** Somebody brought work since this turn began. */
    private volatile boolean woken;

    private volatile boolean selecting;

    /** Another thread works at times; the loop's own looks only whether it still does. */
    private volatile boolean taken;

    private volatile boolean stopped;

    /**
     * @param checkNanos time between two looks at the deadlines
     */
    public EventLoop(RateLimitedLog log, Work work, long checkNanos) throws IOException {
        this.log = log;
        this.work = work;
        this.checkNanos = checkNanos;
        this.selector = Selector.open();
        this.thread = Thread.ofPlatform().name("agents").daemon().unstarted(this::run);
    }

    // ---- any thread ----

    /** Starts the loop's own thread. */
    public void start() {
        thread.start();
    }

    /** Ends after the turn. */
    public void stop() {
        stopped = true;
        wake();
    }

    /** Waits for the end. @return false if it has not ended after that time */
    public boolean join(long millis) throws InterruptedException {
        thread.join(millis);
        return !thread.isAlive();
    }

    /** Has something done on the loop's thread. */
    public void later(Runnable task) {
        tasks.add(task);
        wake();
    }

    /** Makes it look for work. */
    public void wake() {
        if (duty.isHeldByCurrentThread()) {
            return; // it looks for work before it waits
        }
        woken = true;
        if (selecting) {
            selector.wakeup();
        }
    }

    // ---- the loop's thread ----

    /** Tells the handler from now on what the channel is ready for. */
    SelectionKey register(SelectableChannel channel, int operations, Handler handler)
            throws IOException {
        channel.configureBlocking(false);
        return channel.register(selector, operations, handler);
    }

    /**
     * Works in place of the loop's own thread, until something has come or the time is over: from
     * what the last agent says to what that brings about, no thread has to wake another. The loop's
     * own thread goes on where this one does not come back for a while.
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
            // Another thread that waits comes first, however late it gets a processor.
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
     * First what there is to do, then waits for more: so that whoever serves leaves nothing read
     * behind.
     */
    private void turn(long mostNanos, long awakeNanos) {
        try {
            for (Runnable task = tasks.poll(); task != null; task = tasks.poll()) {
                task.run();
            }
            work.run();
            long now = System.nanoTime();
            if (now - checkedNanos >= checkNanos) {
                checkedNanos = now;
                work.checkDeadlines(now);
            }
            select(Math.min(mostNanos, checkedNanos + checkNanos - now), now + awakeNanos);
            quick = System.nanoTime() - now < AWAKE_NANOS;
        } catch (Throwable e) { // one client's error must not end the others
            log.error("serving agents failed", e);
        }
    }

    private void select(long nanoseconds, long awakeUntilNanos) throws IOException {
        selecting = true; // whoever brings work from here on wakes us
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
     * Looks at the sockets again and again.
     *
     * @return true if one of them was ready before there was other work
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
