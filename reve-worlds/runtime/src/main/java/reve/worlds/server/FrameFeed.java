// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;
import reve.core.image.FrameEncoder;
import reve.core.world.WorldEvent;
import reve.core.world.WorldSnapshot;
import reve.worlds.journal.WorldHeader;

import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.locks.LockSupport;

/**
 * The frames of a running world for one reader, which keeps a {@link WorldMirror} on another
 * server. The world never waits for the reader: a slow reader gets only the newest frame, with the
 * events of all frames since the last one that it got. One thread at a time reads; {@link #close}
 * may be called on any thread.
 */
public final class FrameFeed implements AutoCloseable {

    /** Maximum number of events that wait for the reader. The feed of a slower reader ends. */
    private static final int MOST_EVENTS = 100_000;

    /** Minimum time between two frames, for worlds that are as fast as possible [ns]. */
    private static final long INTERVAL_NANOS = 4_000_000;

    /** Maximum time for which a world that ends waits for the reader [ns]. */
    private static final long LAST_NANOS = 300_000_000;

    private final Simulation simulation;
    private final WorldHeader header;
    private final FrameEncoder encoder;
    private final Subscription subscription;
    private final Runnable whenClosed;
    private final Queue<Happened> events = new ConcurrentLinkedQueue<>();
    private final AtomicInteger waiting = new AtomicInteger();

    /** Events of frames that the reader gets with the next frame. */
    private final List<WorldEvent> taken = new ArrayList<>();

    private boolean hasHeader;
    private volatile long sent = -1;
    private long sentNanos = System.nanoTime() - INTERVAL_NANOS;
    private volatile long published;
    private volatile boolean closed;
    private volatile @Nullable Thread reader;

    private record Happened(long frame, List<WorldEvent> events) {}

    /**
     * @param whenClosed is called once when the feed is closed
     */
    FrameFeed(Simulation simulation, WorldHeader header, Runnable whenClosed) {
        this.simulation = simulation;
        this.header = header;
        this.whenClosed = whenClosed;
        this.encoder = new FrameEncoder(header.prototype(), header.assets());
        this.published = simulation.loop().frame();
        this.subscription =
                simulation.bus().subscribe(FramePhase.PUBLISH, "frames to a server", this::note);
    }

    /** Records the events of a frame, when its snapshot is available. */
    private void note(FrameEvent frame) {
        List<WorldEvent> happened = frame.world().events();
        if (!happened.isEmpty() && waiting.addAndGet(happened.size()) <= MOST_EVENTS) {
            events.add(new Happened(frame.frame(), happened));
        }
        published = frame.frame();
        LockSupport.unpark(reader);
    }

    /**
     * Waits for data that the reader does not have. The first data is the header of the world, the
     * second one is a complete frame, and each further one is the newest frame as its differences
     * from the previous one.
     *
     * @return empty if there is no new frame in this time, or the feed is closed
     */
    public Optional<byte[]> next(Duration timeout) throws InterruptedException {
        if (!hasHeader) {
            hasHeader = true;
            return Optional.of(header.write());
        }
        reader = Thread.currentThread();
        try {
            long end = System.nanoTime() + timeout.toNanos();
            while (!closed) {
                long early = sentNanos + INTERVAL_NANOS - System.nanoTime();
                Optional<byte[]> frame = early > 0 ? Optional.empty() : encode();
                long now = System.nanoTime();
                if (frame.isPresent() || end <= now) {
                    sentNanos = frame.isPresent() ? now : sentNanos;
                    return frame;
                }
                LockSupport.parkNanos(this, early > 0 ? early : end - now);
                if (Thread.interrupted()) {
                    throw new InterruptedException();
                }
            }
            return Optional.empty();
        } finally {
            reader = null;
        }
    }

    private synchronized Optional<byte[]> encode() {
        if (closed) {
            return Optional.empty();
        }
        if (waiting.get() > MOST_EVENTS) {
            close(); // the reader begins again, with a complete frame
            return Optional.empty();
        }
        long last = Math.max(published, simulation.loop().frame());
        Optional<WorldSnapshot> newest =
                last == sent ? Optional.empty() : simulation.snapshots().acquireLatest();
        if (newest.isEmpty()) {
            return Optional.empty();
        }
        try (WorldSnapshot snapshot = newest.get()) {
            if (snapshot.frame() == sent || snapshot.frame() > last) {
                return Optional.empty(); // the events of this frame are not recorded yet
            }
            takeEvents(snapshot.frame());
            Optional<byte[]> frame = encoder.write(snapshot, taken);
            if (frame.isPresent()) {
                sent = snapshot.frame();
                taken.clear();
            }
            return frame;
        }
    }

    private void takeEvents(long frame) {
        for (Happened next = events.peek();
                next != null && next.frame <= frame;
                next = events.peek()) {
            events.remove();
            waiting.addAndGet(-next.events.size());
            taken.addAll(next.events);
        }
    }

    /**
     * Ends the feed of a world that makes no more frames. Waits for a short time until the reader
     * has taken the last frame with its events.
     */
    void finish() {
        long end = System.nanoTime() + LAST_NANOS;
        while (!closed && sent < simulation.loop().frame() && System.nanoTime() < end) {
            LockSupport.parkNanos(1_000_000);
        }
        close();
    }

    /** Returns whether the feed has no more frames, because the world has ended here. */
    public boolean isClosed() {
        return closed;
    }

    /**
     * Ends the feed. Waits until a frame that is being encoded is finished; the world may then be
     * freed. Idempotent.
     */
    @Override
    public synchronized void close() {
        if (!closed) {
            closed = true;
            subscription.close();
            LockSupport.unpark(reader);
            whenClosed.run();
        }
    }
}
