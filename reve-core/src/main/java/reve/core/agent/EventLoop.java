package reve.core.agent;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.SelectableChannel;
import java.nio.channels.SelectionKey;
import java.nio.channels.Selector;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.TimeUnit;

/**
 * One thread that reads, writes and works for all agents. It waits for sockets, for other threads and for the clock,
 * never for a client.
 */
final class EventLoop {

    /** What one turn writes for one client goes through it. */
    private static final int WRITE_BUFFER_BYTES = 64 * 1024;

    /** Something that a channel brings work for. */
    interface Handler {
        /** The channel is ready for an operation that the key is interested in. */
        void ready(SelectionKey key);
    }

    /** What is done in every turn, after what channels and tasks brought. */
    interface Work {
        /** True if there is something to do at once. */
        boolean isWaiting();

        void run();

        /** Called every now and then. */
        void checkDeadlines(long nowNanos);
    }

    private final Selector selector;
    private final RateLimitedLog log;
    private final Work work;
    private final long checkNanos;
    private final Thread thread;
    private final Queue<Runnable> tasks = new ConcurrentLinkedQueue<>();
    private final ByteBuffer writeBuffer = ByteBuffer.allocateDirect(WRITE_BUFFER_BYTES);
    private long checkedNanos = System.nanoTime();
    private volatile boolean selecting;
    private volatile boolean stopped;

    /** @param checkNanos time between two looks at the deadlines */
    EventLoop(RateLimitedLog log, Work work, long checkNanos) throws IOException {
        this.log = log;
        this.work = work;
        this.checkNanos = checkNanos;
        this.selector = Selector.open();
        this.thread = Thread.ofPlatform().name("agents").daemon().unstarted(this::run);
    }

    // ---- any thread ----

    void start() {
        thread.start();
    }

    /** Ends after the turn. */
    void stop() {
        stopped = true;
        wake();
    }

    /** Waits for the end. @return false if it has not ended after that time */
    boolean join(long millis) throws InterruptedException {
        thread.join(millis);
        return !thread.isAlive();
    }

    /** Has something done on the loop's thread. */
    void later(Runnable task) {
        tasks.add(task);
        wake();
    }

    /** Makes it look for work. */
    void wake() {
        if (selecting) {
            selector.wakeup();
        }
    }

    // ---- the loop's thread ----

    /** Tells the handler from now on what the channel is ready for. */
    SelectionKey register(SelectableChannel channel, int operations, Handler handler) throws IOException {
        channel.configureBlocking(false);
        return channel.register(selector, operations, handler);
    }

    /** For use in one turn. */
    ByteBuffer writeBuffer() {
        return writeBuffer.clear();
    }

    private void run() {
        while (!stopped) {
            try {
                turn();
            } catch (Throwable e) { // one client's error must not end the others
                log.error("serving agents failed", e);
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

    private void turn() throws IOException {
        long wait = checkedNanos + checkNanos - System.nanoTime();
        selecting = true; // whoever brings work from here on wakes us
        if (wait <= 0 || !tasks.isEmpty() || work.isWaiting() || stopped) {
            selector.selectNow(EventLoop::handle);
        } else {
            selector.select(EventLoop::handle, TimeUnit.NANOSECONDS.toMillis(wait) + 1);
        }
        selecting = false;
        for (Runnable task = tasks.poll(); task != null; task = tasks.poll()) {
            task.run();
        }
        work.run();
        long now = System.nanoTime();
        if (now - checkedNanos >= checkNanos) {
            checkedNanos = now;
            work.checkDeadlines(now);
        }
    }

    private static void handle(SelectionKey key) {
        ((Handler) key.attachment()).ready(key);
    }
}
