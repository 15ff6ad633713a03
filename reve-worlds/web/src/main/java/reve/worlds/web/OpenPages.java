// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.jspecify.annotations.Nullable;

import java.nio.ByteBuffer;
import java.util.IdentityHashMap;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.locks.LockSupport;

/**
 * The connections to all web pages, and the memory of the frames that wait for them. A frame that
 * several pages share is counted once. The pages that have been slow the longest are disconnected
 * if the memory exceeds its limit. For any thread.
 */
final class OpenPages implements AutoCloseable {

    private static final long MOST_BYTES = 256L * 1024 * 1024;

    /** Divisor that computes the memory limit from the size of a small heap. */
    private static final int SHARE = 8;

    private static final long CHECK_NANOS = 500_000_000;

    private final long mostBytes;
    private final long startNanos = System.nanoTime();
    private final Set<PageOutput> open = ConcurrentHashMap.newKeySet();

    /**
     * The frame that waits for each page. The page that has been slow the longest comes first.
     * Guarded by this object's lock.
     */
    private final Map<PageOutput, ByteBuffer> waiting = new LinkedHashMap<>();

    /** Number of pages that wait for each frame. Guarded by this object's lock. */
    private final Map<ByteBuffer, Integer> holders = new IdentityHashMap<>();

    private long bytes;
    private final Thread checker;
    private volatile boolean closed;

    OpenPages() {
        this(Math.min(MOST_BYTES, Runtime.getRuntime().maxMemory() / SHARE));
    }

    /**
     * @param mostBytes limit of the memory of waiting frames [bytes]
     */
    OpenPages(long mostBytes) {
        this.mostBytes = mostBytes;
        this.checker = Thread.ofPlatform().daemon().name("page deadlines").start(this::check);
    }

    /** Returns the time since this object was created [ns]. */
    long nowNanos() {
        return System.nanoTime() - startNanos;
    }

    void add(PageOutput page) {
        open.add(page);
    }

    void remove(PageOutput page) {
        open.remove(page);
        release(page);
    }

    /**
     * Counts a frame that waits for a page. Disconnects the slowest pages if the memory limit is
     * exceeded.
     */
    void hold(PageOutput page, ByteBuffer frame) {
        synchronized (this) {
            release(page);
            waiting.put(page, frame);
            if (holders.merge(frame, 1, Integer::sum) == 1) {
                bytes += frame.limit();
            }
        }
        for (PageOutput slowest = excess(); slowest != null; slowest = excess()) {
            slowest.cut();
        }
    }

    private synchronized @Nullable PageOutput excess() {
        if (bytes <= mostBytes) {
            return null;
        }
        PageOutput slowest = waiting.keySet().iterator().next();
        release(slowest);
        return slowest;
    }

    /** Records that no frame waits for the page. */
    synchronized void release(PageOutput page) {
        ByteBuffer frame = waiting.remove(page);
        if (frame != null && holders.merge(frame, -1, Integer::sum) == 0) {
            holders.remove(frame);
            bytes -= frame.limit();
        }
    }

    /** Returns the memory of all waiting frames [bytes]. */
    synchronized long bytes() {
        return bytes;
    }

    private void check() {
        while (!closed) {
            long now = nowNanos();
            open.forEach(page -> page.check(now));
            LockSupport.parkNanos(this, CHECK_NANOS);
        }
    }

    /** Ends the thread. Idempotent. */
    @Override
    public void close() {
        closed = true;
        LockSupport.unpark(checker);
    }
}
