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
 * Writes what waits for clients. Long rows of them are written by two threads: the event loop's and
 * one that sleeps otherwise, since to write is more work than all else that many clients make.
 * While they do, the event loop does nothing else, so that what belongs to one connection is never
 * in two hands.
 */
final class Writers {

    /** As many clients are worth waking a thread for. */
    private static final int LONG_ROW = 200;

    /** So long the event loop looks whether the other thread is done before it sleeps. */
    private static final long PATIENCE_NANOS = 20_000;

    /** What the writers write to. */
    interface Target {
        /** Writes what waits for it, as far as its socket takes it. */
        void writeQueued(WriteBuffers buffers);
    }

    private final Queue<Target> waiting = new ConcurrentLinkedQueue<>();
    private final WriteBuffers buffers = new WriteBuffers();
    private final Thread helper =
            Thread.ofPlatform().name("agents' writer").daemon().unstarted(this::help);
    private final boolean helped;

    /** Filled and emptied by the event loop while it is closed. */
    private final List<Target> row = new ArrayList<>();

    /** The place in the row of who is written to next. */
    private final AtomicInteger next = new AtomicInteger();

    private volatile boolean open;

    /** The helper looks at the row. Set before it looks whether the row is open. */
    private volatile boolean helping;

    /** Who sleeps until the helper is done. */
    private volatile @Nullable Thread sleeper;

    private volatile boolean stopped;

    /**
     * @param threads that there may be, with the event loop's
     */
    Writers(int threads) {
        this.helped = threads > 1;
    }

    void start() {
        if (helped) {
            helper.start();
        }
    }

    /** On the event loop, which writes to nobody any more. */
    void stop() {
        stopped = true;
        LockSupport.unpark(helper);
    }

    // ---- any thread ----

    /** Has what waits for a client written in the next {@link #writeAll}. */
    void add(Target target) {
        waiting.add(target);
    }

    boolean isWaiting() {
        return !waiting.isEmpty();
    }

    // ---- the event loop's thread ----

    /** For what the event loop writes by itself. */
    WriteBuffers buffers() {
        return buffers;
    }

    /** Writes to all who wait, as far as their sockets take it. */
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

    // ---- either ----

    private void writeRow(WriteBuffers buffers) {
        for (int i = next.getAndIncrement(); i < row.size(); i = next.getAndIncrement()) {
            row.get(i).writeQueued(buffers);
        }
    }

    // ---- the helper ----

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
