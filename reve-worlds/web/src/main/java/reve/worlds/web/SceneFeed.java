// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.slf4j.Logger;
import org.slf4j.LoggerFactory;

import reve.core.agent.port.WorldPort;
import reve.core.world.WorldSnapshot;

import java.util.List;
import java.util.Optional;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.locks.LockSupport;

/**
 * Sends the scene of one world to all its watchers (web pages). One thread reads snapshots and
 * encodes frames. It works only while a watcher has requested a frame. It polls for new frames
 * every few milliseconds, so the world's thread never has to wake it.
 */
final class SceneFeed implements AutoCloseable {

    private static final Logger LOG = LoggerFactory.getLogger("reve.page");

    /** Minimum time between two frames for one watcher [ns]. It is a little less than 1/60 s. */
    private static final long MIN_INTERVAL_NANOS = 15_000_000;

    /** Interval at which the thread polls for a new frame [ns]. */
    private static final long LOOK_NANOS = 2_000_000;

    /** Minimum time between two frames whose contacts are read although no watcher waits [ns]. */
    private static final long LISTEN_NANOS = 4_000_000;

    /**
     * Maximum number of attempts to read a snapshot. An attempt fails if the snapshot is
     * overwritten during the read.
     */
    private static final int ATTEMPTS = 4;

    private final WorldPort port;
    private final Scene scene = new Scene();
    private final SceneWriter writer;
    private final List<Watcher> watchers = new CopyOnWriteArrayList<>();
    private final Thread encoder;

    /** Time at which contacts were last read although no watcher waited [ns]. */
    private long listenedNanos;

    private volatile boolean closed;

    SceneFeed(PageWorld world) {
        this.port = world.port();
        this.writer = new SceneWriter(world.camera());
        this.encoder =
                Thread.ofPlatform()
                        .daemon()
                        .name("page of world " + port.world())
                        .start(this::encode);
    }

    /** Adds a watcher, or records its new request. For any thread. */
    void add(Watcher watcher) {
        if (!watchers.contains(watcher)) {
            watchers.add(watcher);
        }
        wake();
    }

    void remove(Watcher watcher) {
        watchers.remove(watcher);
    }

    /** Makes the encoder's thread check for work. For any thread. */
    void wake() {
        LockSupport.unpark(encoder);
    }

    private void encode() {
        while (!closed) {
            try {
                long wait = serve();
                if (wait < 0) {
                    LockSupport.park(this);
                } else if (wait > 0) {
                    LockSupport.parkNanos(this, wait);
                }
            } catch (RuntimeException | Error failed) {
                LOG.error("a frame for pages failed", failed);
                scene.forget();
                LockSupport.parkNanos(this, 1_000_000_000);
            }
        }
    }

    /**
     * Sends the newest frame to all watchers that wait for it.
     *
     * @return time until the next watcher must be served [ns]; negative if the thread may sleep
     *     until it is woken
     */
    private long serve() {
        boolean waits = false;
        long due = Long.MAX_VALUE;
        boolean listens = false;
        int wanted = 0;
        long now = System.nanoTime();
        for (Watcher watcher : watchers) {
            listens |= watcher.isListening();
            if (watcher.isWaiting()) {
                waits = true;
                wanted |= watcher.wanted();
                due = Math.min(due, watcher.sentNanos() + MIN_INTERVAL_NANOS - now);
            }
        }
        if (listens) {
            wanted |= SceneColumns.CONTACTS_BIT;
        }
        if (!waits || due > 0) {
            if (!listens) {
                return waits ? due : -1;
            }
            // The contacts of each frame are read, also of frames that no watcher receives.
            if (port.loop().frame() != scene.frame() && now - listenedNanos >= LISTEN_NANOS) {
                listenedNanos = now;
                read(SceneColumns.CONTACTS_BIT);
            }
            return waits ? Math.min(due, LOOK_NANOS) : LOOK_NANOS;
        }
        boolean isNew = port.loop().frame() != scene.frame() || !scene.hasRead(wanted);
        if (isNew && !read(wanted)) {
            return LOOK_NANOS;
        }
        long next = LOOK_NANOS;
        for (Watcher watcher : watchers) {
            if (watcher.isReady(scene.version())) {
                long left = watcher.sentNanos() + MIN_INTERVAL_NANOS - now;
                if (left <= 0) {
                    watcher.send(scene, writer, now);
                } else {
                    next = Math.min(next, left);
                }
            }
        }
        return next;
    }

    /**
     * Reads the newest snapshot.
     *
     * @param wanted optional columns to read
     * @return false if the snapshot was overwritten during the read in each attempt
     */
    private boolean read(int wanted) {
        for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
            Optional<WorldSnapshot> newest = port.snapshots().acquireLatest();
            if (newest.isEmpty()) {
                return true;
            }
            try (WorldSnapshot snapshot = newest.get()) {
                if (scene.read(snapshot, wanted)) {
                    return true;
                }
            }
        }
        return false;
    }

    /** Ends the thread like {@link #close}, and waits for its end. */
    void end() {
        close();
        boolean interrupted = false;
        while (encoder.isAlive()) {
            try {
                encoder.join();
            } catch (InterruptedException e) {
                interrupted = true; // the world is freed only when the thread does not read it
            }
        }
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }

    /** Ends the thread. Idempotent. */
    @Override
    public void close() {
        closed = true;
        wake();
    }
}
