// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;
import reve.core.store.WorldDigest;
import reve.core.world.World;
import reve.core.world.WorldChange;
import reve.core.world.WorldEvent;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.PhysicsAdapter;

import java.io.IOError;
import java.io.IOException;
import java.lang.foreign.ValueLayout;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;

/**
 * Keeps a journal of a running world: an image first, and again every so many frames; in between,
 * whatever changed the world other than laws, and a digest of each frame. The world's thread copies
 * and sums up; threads of the journal's own write. No frame is published before the one before it
 * is written, so that the end of the process costs one frame at most, unless the disk lets the
 * world wait for too long. If writing fails the world goes on, and the journal with the next image;
 * a world whose journal itself has ended stops with an IOError. Made and closed by the world's
 * thread, between frames.
 */
public final class Journal implements AutoCloseable {
    private static final int FRAMES_WAITING = 2048;
    private static final int IMAGES_WAITING = 2;
    private static final long PAUSE_NANOSECONDS = 50_000;
    private static final int SPINS = 2_000;

    /** How long a frame waits for the one before it, where the wall clock paces the world [ns]. */
    private static final long FRAME_PATIENCE_NANOSECONDS = 1_000_000_000;

    /** The same if there is a whole image to be written, or to be copied [ns]. */
    private static final long IMAGE_PATIENCE_NANOSECONDS = 5_000_000_000L;

    private final World world;
    private final PhysicsAdapter physics;
    private final Plan plan;
    private final WorldDigest digest;
    private final long[] earlyDigest;
    private final EntryRing ring;
    private final Queue<SimulationImage> rooms = new ConcurrentLinkedQueue<>();
    private final List<Subscription> subscriptions = new ArrayList<>();
    private final Consumer<LawChange> lawListener;
    private final JournalWriter writer;
    private final Consumer<String> problems;
    private final List<Entry.Noted> early = new ArrayList<>();
    private final List<LawChange> laws = new ArrayList<>();
    private Map<String, Long> members;
    private int earlyCount;
    private long lastImage = -1;
    private long lastFrame;
    private boolean published;
    private boolean imageWanted = true;

    /** Whether the disk is behind, and frames no longer wait for it. */
    private boolean behind;

    private Optional<Shortfall> shortfall = Optional.empty();

    /**
     * @param imageFrames an image is written every so many frames; 0 for the first one only
     * @param waits whether the world waits for a slow disk however long it takes, as when nothing
     *     paces it; else, after a second, the operator is told, and the world goes on
     */
    public record Plan(long imageFrames, boolean waits) {}

    /**
     * A journal with images that has ended without the last one.
     *
     * @param reached frame that what is kept leads to, -1 if nothing of the run is kept
     * @param last frame that was published
     */
    public record Shortfall(long reached, long last) {
        @Override
        public String toString() {
            return "its last image could not be written; it "
                    + (reached < 0
                            ? "holds what it held before, and nothing of this run"
                            : "continues from frame " + reached)
                    + (reached < last && last > 0
                            ? ", frames " + (reached + 1) + " to " + last + " are lost"
                            : ", no frame is lost");
        }
    }

    /**
     * What a recording lacks.
     *
     * @param count of frames that are not recorded, the first one and the last
     */
    public record Gap(long count, long first, long last) {
        Gap and(long frame) {
            return new Gap(count + 1, first, frame);
        }

        @Override
        public String toString() {
            return count == 1
                    ? "frame " + first + " is not recorded"
                    : count + " frames from " + first + " to " + last + " are not recorded";
        }
    }

    /**
     * Begins with an image of the next frame that is published.
     *
     * @param members ids of the bodies of agents that are in the world, by agent
     * @param sink closed by the journal
     * @param problems told, on any thread, what went wrong
     */
    public Journal(
            WorldHeader header,
            World world,
            PhysicsAdapter physics,
            FrameBus bus,
            Map<String, Long> members,
            Plan plan,
            JournalSink sink,
            Consumer<String> problems) {
        this.world = world;
        this.physics = physics;
        this.plan = plan;
        this.members = members;
        this.problems = problems;
        digest = new WorldDigest(world);
        earlyDigest = new long[digest.size()];
        ring = new EntryRing(FRAMES_WAITING, digest.size());
        for (int i = 0; i < IMAGES_WAITING; i++) {
            rooms.add(new SimulationImage(world));
        }
        writer = new JournalWriter(header, digest.size(), ring, rooms, plan, sink, problems);
        lawListener = laws::add;
        physics.laws().addListener(lawListener);
        // Results of acts may be told from ACT on; going back is published without one.
        subscriptions.add(bus.subscribe(FramePhase.INTAKE, "journal", this::awaitFrameBefore));
        subscriptions.add(bus.subscribe(FramePhase.ACT, "journal", this::noteEarlyChanges));
        subscriptions.add(bus.subscribe(FramePhase.DERIVE, "journal", this::awaitFrameBefore));
        subscriptions.add(bus.subscribe(FramePhase.PUBLISH, "journal", this::handOver));
        writer.start();
    }

    /** Writes an image of the world as it is now, waits until all is written, and ends. */
    @Override
    public void close() {
        if (subscriptions.isEmpty()) {
            return;
        }
        subscriptions.forEach(Subscription::close);
        subscriptions.clear();
        physics.laws().removeListener(lawListener);
        boolean isNewer = lastFrame > lastImage || !world.changes().isEmpty();
        if (plan.imageFrames > 0 && lastImage >= 0 && isNewer) {
            keepLastImage();
        }
        writer.end();
        rooms.forEach(SimulationImage::close);
        writer.failure()
                .ifPresent(
                        failure ->
                                problems.accept(
                                        "the journal has ended before its last image: " + failure));
        boolean lacks = !writer.isLastImageKept() || writer.reached() < lastFrame;
        if (plan.imageFrames > 0 && published && lacks) {
            shortfall = Optional.of(new Shortfall(writer.reached(), lastFrame));
        }
    }

    /** What is missing from a closed journal with images, if something is. */
    public Optional<Shortfall> shortfall() {
        return shortfall;
    }

    /** What a closed recording lacks, but for what is beyond its limit. */
    public Optional<Gap> gap() {
        return writer.gap();
    }

    private void keepLastImage() {
        Entry entry = waitForEntry();
        if (entry != null) {
            entry.frame = lastFrame;
            entry.members = members;
            entry.last = true;
            entry.image = copy(lastFrame, Long.MAX_VALUE);
            ring.commit();
        }
    }

    /**
     * @throws IOError if nothing more will be written
     */
    private void requireWriter() {
        writer.failure()
                .ifPresent(
                        failure -> {
                            throw new IOError(
                                    new IOException(
                                            "the journal has ended after frame "
                                                    + lastFrame
                                                    + " was handed over: "
                                                    + failure,
                                            failure));
                        });
    }

    /** What is announced is thereby at most one frame ahead of what is written. */
    private void awaitFrameBefore(FrameEvent frame) {
        requireWriter();
        for (int i = 0; i < SPINS && !ring.isEmpty(); i++) {
            Thread.onSpinWait();
        }
        if (ring.isEmpty()) {
            behind = false;
            return;
        }
        long start = System.nanoTime();
        long patience =
                lastFrame == lastImage ? IMAGE_PATIENCE_NANOSECONDS : FRAME_PATIENCE_NANOSECONDS;
        while (!behind && !ring.isEmpty() && writer.isWorking()) {
            LockSupport.parkNanos(PAUSE_NANOSECONDS);
            if (!plan.waits && System.nanoTime() - start > patience) {
                behind = true;
                problems.accept(
                        "the disk is too slow: frame "
                                + (frame.frame() - 1)
                                + " is not written yet, and the world goes on; a crash before it is"
                                + " loses more than one frame");
            }
        }
        requireWriter();
    }

    /** The last listener of ACT: what comes later is not seen by this frame's laws. */
    private void noteEarlyChanges(FrameEvent frame) {
        List<WorldChange> changes = world.changes();
        earlyCount = changes.size();
        for (int i = 0; i < earlyCount; i++) {
            early.add(noted(changes.get(i)));
        }
        if (earlyCount > 0) {
            digest.compute(earlyDigest); // laws would spread at once what an input did to one item
        }
    }

    private void handOver(FrameEvent frame) {
        Entry entry = plan.waits ? waitForEntry() : ring.next();
        requireWriter();
        lastFrame = frame.frame();
        published = true;
        followMembers();
        if (entry == null) {
            skip(frame.frame());
        } else {
            fill(entry, frame.frame());
            if (entry.begins || !imageWanted) {
                ring.commit();
                writer.wake();
            }
        }
        early.clear();
        laws.clear();
        earlyCount = 0;
    }

    /** Frames that are left out are made up for by an image. */
    private void skip(long frame) {
        if (!imageWanted) {
            imageWanted = true;
            problems.accept(
                    "the disk is too slow: frames from "
                            + frame
                            + " on are left out, up to the next image");
        }
    }

    private void fill(Entry entry, long frame) {
        List<WorldChange> changes = world.changes();
        entry.clear();
        entry.frame = frame;
        entry.early.addAll(early);
        System.arraycopy(earlyDigest, 0, entry.earlyDigest, 0, earlyDigest.length);
        for (int i = earlyCount; i < changes.size(); i++) {
            entry.late.add(noted(changes.get(i)));
        }
        entry.laws.addAll(laws);
        entry.events = world.events();
        entry.members = members;
        entry.begins =
                imageWanted
                        || writer.beginsAnew()
                        || world.changesLost() > 0
                        || changes.stream().anyMatch(WorldChange.Restored.class::isInstance);
        if (entry.begins) {
            entry.image =
                    copy(
                            frame,
                            plan.waits
                                    ? Long.MAX_VALUE
                                    : behind || imageWanted ? 0 : IMAGE_PATIENCE_NANOSECONDS);
        } else if (plan.imageFrames > 0 && frame - lastImage >= plan.imageFrames) {
            entry.image = copy(frame, 0);
        }
        if (entry.begins && entry.image == null) {
            requireWriter();
            entry.begins = false; // no room: the next frame tries again
            skip(frame);
        } else if (entry.image != null) {
            imageWanted = false;
            lastImage = frame;
        }
        digest.compute(entry.digest);
    }

    /**
     * Copies the world, as soon as one of the images before it is written.
     *
     * @param patience how long to wait for that [ns]
     * @return null if none is written by then, or the writer has ended
     */
    private @Nullable SimulationImage copy(long frame, long patience) {
        long start = System.nanoTime();
        SimulationImage room = rooms.poll();
        while (room == null && System.nanoTime() - start < patience && writer.isWorking()) {
            LockSupport.parkNanos(PAUSE_NANOSECONDS);
            room = rooms.poll();
        }
        if (room != null) {
            room.copyFrom(world, physics, frame);
        }
        return room;
    }

    /** Null if the writer has ended. */
    private @Nullable Entry waitForEntry() {
        Entry entry = ring.next();
        while (entry == null && writer.isWorking()) {
            LockSupport.parkNanos(PAUSE_NANOSECONDS);
            entry = ring.next();
        }
        return entry;
    }

    private Entry.Noted noted(WorldChange change) {
        return new Entry.Noted(
                change,
                change instanceof WorldChange.ColumnEdited edited
                        ? world.table(edited.kind())
                                .column(edited.property())
                                .segment()
                                .toArray(ValueLayout.JAVA_BYTE)
                        : null);
    }

    private void followMembers() {
        List<WorldEvent> events = world.events();
        for (int i = 0; i < events.size(); i++) {
            members = after(events.get(i), members, world);
        }
    }

    /** Who is in the world after an event, and with which body. */
    static Map<String, Long> after(WorldEvent event, Map<String, Long> members, World world) {
        boolean joined = event.type().equals("joined");
        if (!joined && !event.type().equals("left")) {
            return members;
        }
        Map<String, Long> changed = new LinkedHashMap<>(members);
        String agent = (String) event.fields().get("agent");
        if (joined) {
            world.find((String) event.fields().get("body"))
                    .ifPresent(body -> changed.put(agent, body.id().value()));
        } else {
            changed.remove(agent);
        }
        return changed;
    }
}
