// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameEvent;
import reve.core.frame.FramePhase;
import reve.core.frame.Subscription;
import reve.core.image.WorldDigest;
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
 * The journal of a running world. It begins with an image (the complete state) and contains further
 * images at a fixed interval of frames. Between images it contains, for each frame, a digest and
 * all changes that laws did not cause. The world's thread copies data and computes digests; the
 * journal's threads write. A frame is published only after the previous frame was written.
 * Therefore a crash of the process loses at most one frame, unless a write takes longer than
 * FRAME_PATIENCE_NANOSECONDS. If a write fails, the world continues, and the journal resumes with
 * the next image. If the journal's own thread fails, the world stops with an IOError. The world's
 * thread creates and closes the journal, between frames.
 */
public final class Journal implements AutoCloseable {
    private static final int FRAMES_WAITING = 2048;
    private static final int IMAGES_WAITING = 2;
    private static final long PAUSE_NANOSECONDS = 50_000;
    private static final int SPINS = 2_000;

    /**
     * Maximum time that a frame waits for the previous one to be written, if the world runs in real
     * time [ns].
     */
    private static final long FRAME_PATIENCE_NANOSECONDS = 1_000_000_000;

    /**
     * Maximum time that a frame waits until an earlier image is written or its own image can be
     * copied [ns].
     */
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

    /** True if the disk is too slow. Frames then do not wait for it. */
    private boolean behind;

    /** True if the last attempt to copy an image failed and this failure was reported. */
    private boolean imageFailed;

    private Optional<Shortfall> shortfall = Optional.empty();

    /**
     * The intervals and waiting policy of a journal.
     *
     * @param imageFrames frames between two images; 0 writes the first image only
     * @param waits true if the world waits for a slow disk without limit, as worlds without a fixed
     *     rate do. If false, the journal warns the operator after a second, and the world continues
     *     without waiting.
     */
    public record Plan(long imageFrames, boolean waits) {}

    /**
     * A report that a journal with images ended without its last image.
     *
     * @param reached last frame that the journal can restore; -1 if it can restore no frame of this
     *     run
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
     * The frames that a recording lacks.
     *
     * @param count number of missing frames
     * @param first the first missing frame
     * @param last the last missing frame
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
     * Begins the journal. Its first record is an image of the next published frame.
     *
     * @param members ids of the bodies of agents in the world, by agent
     * @param sink storage, which the journal closes
     * @param problems receives messages about failures, on any thread
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
        // The journal subscribes to both INTAKE and ACT, for two reasons. The server may send
        // results of acts from ACT on. A rewind publishes a frame without INTAKE.
        subscriptions.add(bus.subscribe(FramePhase.INTAKE, "journal", this::awaitFrameBefore));
        subscriptions.add(bus.subscribe(FramePhase.ACT, "journal", this::noteEarlyChanges));
        subscriptions.add(bus.subscribe(FramePhase.DERIVE, "journal", this::awaitFrameBefore));
        subscriptions.add(bus.subscribe(FramePhase.PUBLISH, "journal", this::handOver));
        writer.start();
    }

    /**
     * Writes an image of the current world, waits until all data is written, and ends the journal.
     */
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
                .filter(failure -> !(failure instanceof JournalSink.LostException))
                .ifPresent(
                        failure ->
                                problems.accept(
                                        "the journal has ended before its last image: " + failure));
        boolean lacks = !writer.isLastImageKept() || writer.reached() < lastFrame;
        if (plan.imageFrames > 0 && published && lacks) {
            shortfall = Optional.of(new Shortfall(writer.reached(), lastFrame));
        }
    }

    /** Returns what a journal with images lacks; empty if it is complete. Call after close. */
    public Optional<Shortfall> shortfall() {
        return shortfall;
    }

    /**
     * Returns the frames that a recording lacks, except those beyond its size limit. Call after
     * close.
     */
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
     * Stops the world if the writer has ended.
     *
     * @throws IOError if the writer has ended
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

    /**
     * Waits until the previous frame is written. Therefore the frames that agents have received are
     * at most one frame ahead of the journal.
     */
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
        boolean waits = plan.waits || !writer.isFailing();
        while (waits && !behind && !ring.isEmpty() && writer.isWorking()) {
            LockSupport.parkNanos(PAUSE_NANOSECONDS);
            if (!plan.waits && System.nanoTime() - start > patience) {
                behind = true;
                problems.accept(
                        "the disk is too slow: frame "
                                + (frame.frame() - 1)
                                + " is not written yet, and the world continues; a crash before it is"
                                + " loses more than one frame");
            }
        }
        requireWriter();
    }

    /**
     * Records the changes before PHYSICS, the phase in which laws act. Runs as the last listener of
     * ACT, because later changes come after the laws of this frame.
     */
    private void noteEarlyChanges(FrameEvent frame) {
        List<WorldChange> changes = world.changes();
        earlyCount = changes.size();
        for (int i = 0; i < earlyCount; i++) {
            early.add(noted(changes.get(i)));
        }
        if (earlyCount > 0) {
            // This digest helps to locate a deviation, because the laws of the frame have not yet
            // spread it from one item to others.
            digest.compute(earlyDigest);
        }
    }

    private void handOver(FrameEvent frame) {
        Entry entry = plan.waits ? waitForEntry() : ring.next();
        requireWriter();
        lastFrame = frame.frame();
        published = true;
        followMembers();
        boolean handedOver = false;
        try {
            if (entry == null) {
                skip(frame.frame());
            } else {
                fill(entry, frame.frame());
                if (entry.begins || !imageWanted) {
                    ring.commit();
                    writer.wake();
                }
            }
            handedOver = true;
        } finally {
            imageWanted |= !handedOver; // otherwise the frame would be missing without notice
            early.clear();
            laws.clear();
            earlyCount = 0;
        }
    }

    /** Omits a frame from the journal. An image later replaces the omitted frames. */
    private void skip(long frame) {
        if (!imageWanted) {
            imageWanted = true;
            problems.accept(
                    "the disk is too slow: frames from "
                            + frame
                            + " on are omitted, up to the next image");
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
                                    : behind || imageWanted || writer.isFailing()
                                            ? 0
                                            : IMAGE_PATIENCE_NANOSECONDS);
        } else if (plan.imageFrames > 0 && frame - lastImage >= plan.imageFrames) {
            entry.image = copy(frame, 0);
        }
        if (entry.begins && entry.image == null) {
            requireWriter();
            entry.begins = false; // the next frame tries again
            if (imageFailed) {
                imageWanted = true;
            } else {
                skip(frame);
            }
        } else if (entry.image != null) {
            imageWanted = false;
            lastImage = frame;
        }
        digest.compute(entry.digest);
    }

    /**
     * Copies the world into an image as soon as one of the image buffers is free.
     *
     * @param patience maximum wait for a buffer [ns]
     * @return null if no buffer is free by then, the writer has ended, or the copy failed
     */
    private @Nullable SimulationImage copy(long frame, long patience) {
        long start = System.nanoTime();
        SimulationImage room = rooms.poll();
        while (room == null && System.nanoTime() - start < patience && writer.isWorking()) {
            LockSupport.parkNanos(PAUSE_NANOSECONDS);
            room = rooms.poll();
        }
        if (room == null) {
            return null;
        }
        try {
            room.copyFrom(world, physics, frame);
            imageFailed = false;
            return room;
        } catch (RuntimeException failure) { // thrown by the engine, whose process may be replaced
            rooms.add(room);
            if (!imageFailed) {
                imageFailed = true;
                problems.accept(
                        "the image of frame "
                                + frame
                                + " could not be copied: "
                                + failure.getMessage()
                                + "; the next frame tries again");
            }
            return null;
        }
    }

    /** Waits for a free entry. Returns null if the writer has ended. */
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

    /** Returns the ids of the agents' bodies, by agent, after an event. */
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
