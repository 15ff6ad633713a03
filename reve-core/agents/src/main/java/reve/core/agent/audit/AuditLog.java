// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.audit;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.agent.protocol.Encoding;

import java.io.Closeable;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.time.Duration;
import java.time.Instant;
import java.time.InstantSource;
import java.util.List;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.TimeoutException;
import java.util.concurrent.atomic.AtomicLong;

/**
 * A record of every message to clients with its time. A separate thread writes the file. A disk
 * that does not answer therefore delays no client, except as stated below. Messages wait for this
 * thread in a queue of at most {@link #MOST_WAITING_BYTES}. A message has no record if the queue is
 * full, or if the disk has not answered for {@link #PATIENCE_MILLIS}. The record later states the
 * number of such messages.
 *
 * <p>The plan may require the record. The caller of {@link #told} then waits for the disk, at most
 * for {@link #PATIENCE_MILLIS}, and must not send a message without a record.
 *
 * <p>For any thread, unless a method says otherwise. Only {@link #told} and {@link #close} wait.
 */
public final class AuditLog implements Closeable {
    private static final Logger LOG = LoggerFactory.getLogger("reve.agents");

    /** Time after which a disk that does not answer counts as a failure [ms]. */
    static final long PATIENCE_MILLIS = 1000;

    /** Maximum size of the messages that wait for the disk [bytes]. */
    static final long MOST_WAITING_BYTES = 32L << 20;

    /** Minimum interval in which the file is examined for problems [ns]. */
    private static final long LOOK_NANOS = TimeUnit.MILLISECONDS.toNanos(100);

    /** Time that {@link #close} waits for the disk [ms]. */
    private static final long CLOSE_MILLIS = 5000;

    /** The task after which the thread ends. */
    private static final Task END = new Task(() -> {}, 0);

    /**
     * An empty task, which the thread runs if the queue is empty. The thread may then examine the
     * file, as it may after each task.
     */
    private static final Task NONE = new Task(() -> {}, 0);

    private final AuditPlan plan;
    private final long patienceMillis;
    private final AuditFile file;
    private final InstantSource clock;
    private final Thread thread;
    private final LinkedBlockingQueue<Task> tasks = new LinkedBlockingQueue<>();
    private final AtomicLong waitingBytes = new AtomicLong();

    /** Number of messages that the file has not recorded, as known to the writing thread. */
    private volatile long unrecorded;

    /** Time at which the writing thread began its current task [ns]; 0 if it has no task. */
    private volatile long busySince;

    private volatile Optional<String> problem = Optional.empty();
    private volatile String solved;
    private volatile boolean serving = true;

    /**
     * True if a caller has read the result of the last examination of the file. The thread then
     * examines the file again.
     */
    private volatile boolean asked = true;

    private volatile boolean closed;

    private final Object skipping = new Object();

    /** Number of messages that were sent without a record and that the file does not count yet. */
    private long skipped; // guarded by skipping

    private Instant skippedSince = Instant.EPOCH; // guarded by skipping

    /** True if a message was sent without a record since the last report of problems. */
    private boolean hasSkipped; // guarded by skipping

    /** A task of the writing thread, and the number of bytes that wait for it. */
    private record Task(Runnable work, long bytes) {}

    /**
     * @throws IOException if the file cannot be appended to, or is no audit record
     */
    public AuditLog(AuditPlan plan) throws IOException {
        this(plan, PATIENCE_MILLIS);
    }

    /**
     * @param patienceMillis maximum time that a message waits for the disk [ms]
     */
    AuditLog(AuditPlan plan, long patienceMillis) throws IOException {
        this.plan = plan;
        this.patienceMillis = patienceMillis;
        this.clock = InstantSource.system();
        this.file = new AuditFile(plan, clock, System::nanoTime);
        this.solved = file.solved();
        this.thread = Thread.ofPlatform().daemon().name("audit record").start(this::write);
    }

    /**
     * Records a message that is about to be written to a connection. The line may be reused after
     * this call.
     *
     * @return false if recording failed and the message must therefore not be sent
     */
    public boolean told(String world, String client, Encoding encoding, ByteBuffer line) {
        int length = line.remaining();
        if (isLate()
                || !isServing()
                || waitingBytes.get() + length > MOST_WAITING_BYTES
                || closed) {
            return skip();
        }
        Instant at = clock.instant();
        ByteBuffer copy = ByteBuffer.allocate(length).put(line.slice()).flip();
        var recorded = new CompletableFuture<Boolean>();
        waitingBytes.addAndGet(length);
        tasks.add(new Task(() -> record(at, world, client, encoding, copy, recorded), length));
        return !plan.required() || await(recorded);
    }

    private void record(
            Instant at,
            String world,
            String client,
            Encoding encoding,
            ByteBuffer line,
            CompletableFuture<Boolean> recorded) {
        try {
            recorded.complete(file.told(at, world, client, encoding, line));
        } catch (RuntimeException e) { // an error because of one message must not end the thread
            LOG.error("a message to {} could not be recorded", client, e);
            recorded.complete(false);
            if (!plan.required()) {
                file.skipped(1, at);
            }
        }
    }

    private boolean await(CompletableFuture<Boolean> recorded) {
        try {
            if (recorded.get(patienceMillis, TimeUnit.MILLISECONDS)) {
                return true;
            }
        } catch (ExecutionException | TimeoutException e) {
            // A message whose recording fails, or takes too long, counts as not recorded.
        } catch (InterruptedException ending) {
            Thread.currentThread().interrupt();
        }
        serving = false;
        return false;
    }

    private boolean skip() {
        if (plan.required()) {
            serving = false;
            return false;
        }
        synchronized (skipping) {
            if (skipped++ == 0) {
                skippedSince = clock.instant();
                tasks.add(new Task(this::recordSkipped, 0)); // runs after the waiting messages
            }
            hasSkipped = true;
        }
        return true;
    }

    /** Returns whether the disk has not answered for more than {@link #PATIENCE_MILLIS}. */
    private boolean isLate() {
        long since = busySince;
        return since != 0
                && System.nanoTime() - since > TimeUnit.MILLISECONDS.toNanos(patienceMillis);
    }

    /**
     * Returns whether messages may be sent. They may be sent if the record can be written or is not
     * required.
     */
    public boolean isServing() {
        return !plan.required() || serving && !isLate();
    }

    /**
     * Returns why the record cannot be written or rotated, or what another program did to the file;
     * empty if there is no problem. A new record begins at the path of a file that was moved,
     * removed or truncated. Each problem is returned at least once. The result comes from an
     * examination of the file after the previous call.
     */
    public Optional<String> problem() {
        if (isLate() || takeSkipped()) {
            return Optional.of(
                    "what clients are sent cannot be recorded in "
                            + plan.file()
                            + ": the disk is too slow (a message waits at most "
                            + patienceMillis
                            + " ms for it)"
                            + plan.consequence());
        }
        Optional<String> found = problem;
        asked = true;
        return found;
    }

    private boolean takeSkipped() {
        synchronized (skipping) {
            boolean taken = hasSkipped;
            hasSkipped = false;
            return taken;
        }
    }

    /** Returns the message for the operator that a problem has ended. */
    public String solved() {
        return solved;
    }

    /**
     * Returns the newest records of a world, the newest first. The log keeps some hundred records
     * of each world in memory, from the start of the server on.
     *
     * @param client the client whose records are returned; empty for all clients
     * @param frequent whether the records of perceptions, reports, pings and pongs are returned,
     *     too
     * @param most maximum number of records
     */
    public List<AuditRecord> newest(
            String world, Optional<String> client, boolean frequent, int most) {
        return file.recent().newest(world, client, frequent, most);
    }

    /** Returns the number of messages sent so far without a record. */
    public long unrecorded() {
        synchronized (skipping) {
            return unrecorded + skipped;
        }
    }

    /**
     * Writes the waiting messages, and closes the file. Gives up after five seconds if the disk
     * does not answer; {@link #unrecorded} then counts the messages that wait.
     */
    @Override
    public void close() throws IOException {
        closed = true;
        tasks.add(END);
        try {
            if (!thread.join(Duration.ofMillis(CLOSE_MILLIS))) {
                synchronized (skipping) {
                    skipped += tasks.size(); // END replaces the message being written
                }
            }
        } catch (InterruptedException ending) {
            Thread.currentThread().interrupt();
        }
    }

    // ---- the writing thread ----

    private void write() {
        long looked = 0;
        Task task = NONE;
        while (task != END) {
            task = next();
            busySince = Math.max(1, System.nanoTime());
            task.work().run();
            waitingBytes.addAndGet(-task.bytes());
            if ((asked || !serving) && System.nanoTime() - looked > LOOK_NANOS) {
                looked = System.nanoTime();
                asked = false;
                look();
            }
            unrecorded = file.unrecorded();
            busySince = 0;
        }
        try {
            file.close();
        } catch (IOException e) {
            // The file buffers no data, so a failed close loses nothing.
        }
    }

    private Task next() {
        try {
            Task next = tasks.poll(LOOK_NANOS, TimeUnit.NANOSECONDS);
            return next == null ? NONE : next;
        } catch (InterruptedException e) {
            throw new AssertionError("no one interrupts this thread", e);
        }
    }

    private void recordSkipped() {
        long messages;
        Instant since;
        synchronized (skipping) {
            messages = skipped;
            since = skippedSince;
            skipped = 0;
            unrecorded += messages; // file.unrecorded() counts these from now on
        }
        file.skipped(messages, since);
        solved = file.solved();
    }

    private void look() {
        problem = file.problem();
        if (problem.isEmpty()) {
            solved = file.solved();
        }
        serving = file.isServing();
    }
}
