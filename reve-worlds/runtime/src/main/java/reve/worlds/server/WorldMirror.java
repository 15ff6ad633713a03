// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.agent.port.Cameras;
import reve.core.agent.port.WorldControl;
import reve.core.agent.port.WorldPort;
import reve.core.file.AgentPolicy;
import reve.core.frame.CommandQueue;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.core.image.FrameDecoder;
import reve.core.world.OffHeapArena;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldImage;
import reve.worlds.journal.WorldHeader;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.concurrent.Semaphore;
import java.util.concurrent.TimeUnit;
import java.util.function.LongConsumer;

/**
 * A copy of a world that another server runs. The copy has the frames of a {@link FrameFeed}, and
 * neither laws nor rules: it shows what the other server has computed. The server of agents and the
 * page read it like any other world. One thread shows frames; the copy has a thread of its own, on
 * which its listeners are called.
 */
final class WorldMirror implements AutoCloseable {
    private static final int SNAPSHOT_SLOTS = 4;
    private static final int COMMANDS = 16;
    private static final long CHECK_MILLIS = 100;

    private final WorldHeader header;
    private final OffHeapArena arena = new OffHeapArena();
    private final World world;
    private final WorldImage image;
    private final FrameBus bus = new FrameBus();
    private final SnapshotRing snapshots;
    private final FrameLoop loop;
    private final Thread thread;
    private final Semaphore shown = new Semaphore(0);
    private final LongConsumer whenRewound;
    private FrameDecoder decoder;

    /** Events of frames that were not shown. */
    private final List<WorldEvent> waiting = new ArrayList<>();

    /** Whether frames are missing before the next one. */
    private boolean isGap;

    private volatile @Nullable RuntimeException failure;

    /**
     * @param first the first frame of the feed
     * @param whenRewound receives the number of a frame before which the world was rewound, on the
     *     thread of the copy, before the frame is published
     * @throws CorruptException if the frame does not fit the header
     */
    WorldMirror(WorldHeader header, byte[] first, LongConsumer whenRewound) {
        this.header = header;
        this.whenRewound = whenRewound;
        world = new World(header.name(), header.prototype(), arena);
        image = new WorldImage(world);
        try {
            snapshots = new SnapshotRing(world, SNAPSHOT_SLOTS);
            loop = new FrameLoop(world, bus, header.timing(), Pacing.REAL_TIME);
            bus.subscribe(
                    FramePhase.PUBLISH,
                    "snapshots",
                    frame -> snapshots.publish(frame.frame(), frame.timeSeconds()));
            decoder = new FrameDecoder(header.prototype(), header.assets());
            apply(decode(first));
            loop.suspend(true); // the other server makes the frames
            thread =
                    Thread.ofPlatform()
                            .daemon()
                            .name("copy of world " + header.name())
                            .unstarted(loop::run);
        } catch (RuntimeException refused) {
            image.close();
            arena.close();
            throw refused;
        }
    }

    /** Shows the first frame. Called after listeners of {@link #port} have subscribed. */
    void start() {
        thread.start();
    }

    /** Returns the interface for the server of agents and the page. */
    WorldPort port() {
        return new WorldPort(
                header.name(),
                header.timing().framesPerSecond(),
                AgentPolicy.none(),
                bus,
                new CommandQueue(COMMANDS),
                snapshots,
                loop,
                WorldControl.none(
                        "this server only watches the world "
                                + header.name()
                                + "; ask the node that runs it, which `cluster status` shows"),
                Cameras.none());
    }

    /**
     * Shows a frame. Returns when the copy has taken it over. A frame that is not newer than the
     * last one is not shown: the world resumed at an earlier frame after a loss.
     *
     * @throws CorruptException if the frame does not fit the previous one
     */
    void show(byte[] frame) throws InterruptedException {
        FrameDecoder.Frame decoded = decode(frame);
        waiting.addAll(decoded.events());
        if (decoded.frame() <= loop.frame()) {
            return;
        }
        loop.betweenFrames(
                () -> {
                    try {
                        apply(decoded);
                    } catch (RuntimeException wrong) {
                        failure = wrong;
                    } finally {
                        shown.release();
                    }
                });
        while (!shown.tryAcquire(CHECK_MILLIS, TimeUnit.MILLISECONDS)) {
            if (!thread.isAlive()) {
                throw new IllegalStateException("the copy of world " + header.name() + " ended");
            }
        }
        RuntimeException wrong = failure;
        if (wrong != null) {
            throw wrong;
        }
    }

    /**
     * Continues with another feed of the same world.
     *
     * @param first the first frame of the feed
     * @return false, without effect, if the world has other properties, so that clients must join
     *     again
     */
    boolean continueWith(WorldHeader other, byte[] first) throws InterruptedException {
        if (!Arrays.equals(other.write(), header.write())) {
            return false;
        }
        isGap = true;
        decoder = new FrameDecoder(header.prototype(), header.assets());
        show(first);
        return true;
    }

    private FrameDecoder.Frame decode(byte[] frame) {
        FrameDecoder.Frame decoded = decoder.read(frame, image);
        image.setAge(Math.round(decoded.time() * header.timing().framesPerSecond()));
        return decoded;
    }

    private void apply(FrameDecoder.Frame frame) {
        long before = loop.frame();
        loop.requireContinuable(frame.frame());
        world.restore(image);
        if (isGap && frame.frame() > before + 1) {
            Map<String, Object> frames = new LinkedHashMap<>();
            frames.put("first", before + 1);
            frames.put("last", frame.frame() - 1);
            world.raise(new WorldEvent(frame.frame(), "missed", frames));
        }
        isGap = false;
        waiting.forEach(world::raise);
        loop.continueAfter(frame.frame());
        if (waiting.stream().anyMatch(event -> event.type().equals("rewound"))) {
            whenRewound.accept(frame.frame());
        }
        waiting.clear();
    }

    /** Ends the thread of the copy, and frees the copy. No one may read it after this call. */
    @Override
    public void close() {
        loop.stop();
        boolean interrupted = false;
        while (thread.isAlive()) {
            try {
                thread.join();
            } catch (InterruptedException e) {
                interrupted = true; // the copy is freed only when its thread does not read it
            }
        }
        image.close();
        arena.close();
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }
}
