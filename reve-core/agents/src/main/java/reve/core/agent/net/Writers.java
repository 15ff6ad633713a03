// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import org.jspecify.annotations.Nullable;

import java.util.ArrayList;
import java.util.List;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.locks.LockSupport;

/**
 * Writes waiting messages to clients. Writing to many clients is most of the server's work.
 * Therefore a helper thread and the event loop's thread both take clients from the queue. The
 * helper sleeps while the queue is short. The event loop waits for the helper before it continues.
 * Therefore the loop never uses a connection to which the helper still writes.
 */
final class Writers {

    /** Minimum number of clients for which the helper thread is woken. */
    private static final int LONG_ROW = 200;

    /** Maximum busy-wait of the event loop for the helper before the loop's thread blocks [ns]. */
    private static final long PATIENCE_NANOS = 20_000;

    /** A connection to write to. */
    interface Target {
        /** Writes waiting messages until the socket accepts no more. */
        void writeQueued(WriteBuffers buffers);
    }

    private final Queue<Target> waiting = new ConcurrentLinkedQueue<>();
    private final WriteBuffers buffers = new WriteBuffers();
    private final Thread helper =
            Thread.ofPlatform().name("agents' writer").daemon().unstarted(this::help);
    private final boolean helped;

    /**
     * The connections to write to. The event loop changes this list only while {@link #open} is
     * false.
     */
    private final List<Target> row = new ArrayList<>();

    /** Index of the next target in {@link #row}. */
    private final AtomicInteger next = new AtomicInteger();

    private volatile boolean open;

    /**
     * True while the helper may write to targets. The helper sets this field before it checks
     * {@link #open}.
     */
    private volatile boolean helping;

    /**
     * The event loop's thread while it is blocked until the helper has finished; null otherwise.
     */
    private volatile @Nullable Thread sleeper;

    private volatile boolean stopped;

    /**
     * @param threads maximum number of threads, including the event loop's
     */
    Writers(int threads) {
        this.helped = threads > 1;
    }

    void start() {
        if (helped) {
            helper.start();
        }
    }

    /** Stops the helper. Called on the event loop's thread, which must not write afterwards. */
    void stop() {
        stopped = true;
        LockSupport.unpark(helper);
    }

    // ---- methods for any thread ----

    /** Schedules a target for the next {@link #writeAll}. */
    void add(Target target) {
        waiting.add(target);
    }

    boolean isWaiting() {
        return !waiting.isEmpty();
    }

    // ---- methods for the event loop's thread ----

    /** Returns the buffers of the event loop's thread. */
    WriteBuffers buffers() {
        return buffers;
    }

    /** Writes to all scheduled targets until their sockets accept no more. */
    void writeAll() {
        for (Target target = waiting.poll(); target != null; target = waiting.poll()) {
            row.add(target);
        }
        next.set(0);
        if (helped && row.size() >= LONG_ROW) {
            open = true;
            LockSupport.unpark(helper);
            writeRow(buffers);
            open = false;
            awaitHelper();
        } else {
            writeRow(buffers);
        }
        row.clear();
    }

    private void awaitHelper() {
        long patience = System.nanoTime() + PATIENCE_NANOS;
        while (helping && System.nanoTime() - patience < 0) {
            Thread.onSpinWait();
        }
        sleeper = Thread.currentThread();
        while (helping) {
            LockSupport.park(this);
        }
        sleeper = null;
    }

    // ---- methods for the event loop's thread and the helper thread ----

    private void writeRow(WriteBuffers buffers) {
        for (int i = next.getAndIncrement(); i < row.size(); i = next.getAndIncrement()) {
            row.get(i).writeQueued(buffers);
        }
    }

    // ---- methods for the helper thread ----

    private void help() {
        var own = new WriteBuffers();
        while (!stopped) {
            helping = true;
            if (open) {
                writeRow(own);
            }
            helping = false;
            LockSupport.unpark(sleeper);
            LockSupport.park(this);
        }
    }
}
