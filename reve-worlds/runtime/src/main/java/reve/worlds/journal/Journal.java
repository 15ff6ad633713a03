// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.agent.port.SessionNote;
import reve.core.file.RuleChanges;
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
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.ConcurrentLinkedQueue;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;
import java.util.function.Supplier;

/**
 * The journal of a running world. It begins with an image (the complete state) and contains further
 * images at a fixed interval of frames. Between images, it contains a digest of each frame, and all
 * changes that laws did not cause. The world's thread copies data and computes digests; the
 * journal's threads write.
 *
 * <p>A frame is published only after the previous frame was written. Therefore a crash of the
 * process loses at most one frame. It may lose more frames if a write takes longer than
 * FRAME_PATIENCE_NANOSECONDS. The world continues if a write fails, and the journal resumes with
 * the next image. The world stops with an IOError if the journal's own thread fails. The world's
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
     * Maximum time that a frame waits until the first image, or the first image after a rewind, is
     * written. Also the maximum time that a frame waits until its own image can be copied [ns].
     */
    private static final long IMAGE_PATIENCE_NANOSECONDS = 5_000_000_000L;

    /** Length of the periods over which the waits of frames for the disk are summed [ns]. */
    private static final long PERIOD_NANOSECONDS = 5_000_000_000L;

    /** Minimum time between two reports about a disk that slows the world [ns]. */
    private static final long REPORT_NANOSECONDS = 60_000_000_000L;

    private final World world;
    private final PhysicsAdapter physics;
    private final Plan plan;
    private final WorldDigest digest;
    private final long[] earlyDigest;
    private final EntryRing ring;
    private final Queue<SimulationImage> rooms = new ConcurrentLinkedQueue<>();

    /** Changes of sessions that no frame contains yet. */
    private final Queue<SessionNote> sessions = new ConcurrentLinkedQueue<>();

    private final boolean keepsSessions;
    private final List<Subscription> subscriptions = new ArrayList<>();
    private final Consumer<LawChange> lawListener;
    private final JournalWriter writer;
    private final Consumer<String> problems;
    private final List<Entry.Noted> early = new ArrayList<>();
    private final List<LawChange> laws = new ArrayList<>();
    private final List<RuleChanges.Change> rules = new ArrayList<>();
    private final Supplier<RuleChanges> allRules;
    private Map<String, Long> members;
    private int earlyCount;
    private long lastImage = -1;

    /** Frame of the first image, or of the newest image after a rewind. */
    private long lastBeginning = -1;

    private long periodStart = System.nanoTime();

    /** Time that frames have waited for the disk since the period began [ns]. */
    private long waitedNanos;

    /** Time of the last report about a disk that slows the world [ns]; 0 if there was none. */
    private long reportedNanos;

    private long lastFrame;

    /** The first frame of this run; -1 before it is published. */
    private long firstFrame = -1;

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
     * The report about a journal that ended without its last image.
     *
     * @param reached last frame that the journal can restore; -1 if it can restore no frame of this
     *     run
     * @param first the first frame of this run
     * @param last frame that was published
     */
    public record Shortfall(long reached, long first, long last) {
        @Override
        public String toString() {
            return "its last image could not be written; it "
                    + (reached < 0
                            ? "holds what it held before, and nothing of this run"
                            : "continues from frame " + reached)
                    + (reached < last && last > 0
                            ? ", frames "
                                    + Math.max(reached + 1, first)
                                    + " to "
                                    + last
                                    + " are lost"
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
     * @param allRules returns the changes of the world's rules since its world file
     * @param sink storage, which the journal closes
     * @param problems receives messages about failures, on any thread
     */
    public Journal(
            WorldHeader header,
            World world,
            PhysicsAdapter physics,
            FrameBus bus,
            Map<String, Long> members,
            Supplier<RuleChanges> allRules,
            Plan plan,
            JournalSink sink,
            Consumer<String> problems) {
        this.world = world;
        this.allRules = allRules;
        this.physics = physics;
        this.plan = plan;
        this.members = members;
        this.problems = problems;
        keepsSessions = sink.keepsSessions();
        digest = new WorldDigest(world);
        earlyDigest = new long[digest.size()];
        ring = new EntryRing(FRAMES_WAITING, digest.size());
        for (int i = 0; i < IMAGES_WAITING; i++) {
            rooms.add(new SimulationImage(world));
        }
        writer = new JournalWriter(header, digest.size(), ring, rooms, plan, sink, problems);
        lawListener = laws::add;
        physics.laws().addListener(lawListener);
        // The journal waits for the previous frame in INTAKE and also in ACT. The server may send
        // results of acts as soon as ACT begins, and a rewind publishes a frame without INTAKE.
        subscriptions.add(bus.subscribe(FramePhase.INTAKE, "journal", this::awaitFrameBefore));
        subscriptions.add(bus.subscribe(FramePhase.ACT, "journal", this::noteEarlyChanges));
        subscriptions.add(bus.subscribe(FramePhase.DERIVE, "journal", this::awaitFrameBefore));
        subscriptions.add(bus.subscribe(FramePhase.PUBLISH, "journal", this::handOver));
        writer.start();
    }

    /**
     * Returns whether the last write failed, and the frames since then are not kept. For any
     * thread.
     */
    public boolean isFailing() {
        return writer.isFailing();
    }

    /**
     * Returns whether the journal's storage keeps notes about sessions, for another server. For any
     * thread.
     */
    public boolean keepsSessions() {
        return keepsSessions;
    }

    /** Adds a note about a session to the frame that is published next. For any thread. */
    public void note(SessionNote note) {
        if (keepsSessions) {
            sessions.add(note);
        }
    }

    /** Adds changes of the world's rules to the frame that is published next. */
    public void rulesChanged(List<RuleChanges.Change> changes) {
        if (!subscriptions.isEmpty()) {
            rules.addAll(changes);
        }
    }

    /** Moves the notes about sessions to an entry that is about to be committed. */
    private void takeNotes(Entry entry) {
        entry.sessions = List.of();
        if (sessions.isEmpty()) {
            return;
        }
        List<SessionNote> taken = new ArrayList<>();
        for (SessionNote note = sessions.poll(); note != null; note = sessions.poll()) {
            taken.add(note);
        }
        entry.sessions = taken;
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
        boolean isNewer = lastFrame > lastImage || !world.changes().isEmpty() || !rules.isEmpty();
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
            shortfall = Optional.of(new Shortfall(writer.reached(), firstFrame, lastFrame));
        }
    }

    /**
     * Returns the frames that a journal with images lacks at its end; empty if the journal is
     * complete. Call this method after close.
     */
    public Optional<Shortfall> shortfall() {
        return shortfall;
    }

    /**
     * Returns the frames that a recording lacks, except those beyond its size limit. Call this
     * method after close.
     */
    public Optional<Gap> gap() {
        return writer.gap();
    }

    private void keepLastImage() {
        Entry entry = waitForEntry();
        if (entry != null) {
            entry.frame = lastFrame;
            entry.members = members;
            entry.allRules = allRules.get();
            entry.last = true;
            entry.image = copy(lastFrame, Long.MAX_VALUE);
            takeNotes(entry);
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
                lastFrame == lastBeginning
                        ? IMAGE_PATIENCE_NANOSECONDS
                        : FRAME_PATIENCE_NANOSECONDS;
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
        if (!plan.waits) {
            countWait(start, System.nanoTime());
        }
        requireWriter();
    }

    /**
     * Adds up the waits for the disk. Reports a disk for which the world waits most of the time.
     */
    private void countWait(long start, long now) {
        waitedNanos += now - start;
        long elapsed = now - periodStart;
        if (elapsed < PERIOD_NANOSECONDS) {
            return;
        }
        boolean isDue = reportedNanos == 0 || now - reportedNanos > REPORT_NANOSECONDS;
        if (2 * waitedNanos > elapsed && isDue) {
            reportedNanos = now;
            problems.accept(
                    String.format(
                            Locale.ROOT,
                            "the disk is slow: the world waited for it %.1f of the last %.1f s,"
                                    + " because each frame is written before the next one",
                            waitedNanos / 1e9,
                            elapsed / 1e9));
        }
        periodStart = now;
        waitedNanos = 0;
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
        if (firstFrame < 0) {
            firstFrame = lastFrame;
        }
        published = true;
        followMembers();
        boolean handedOver = false;
        try {
            if (entry == null) {
                skip(frame.frame());
            } else {
                fill(entry, frame.frame());
                if (entry.begins || !imageWanted) {
                    takeNotes(entry);
                    ring.commit();
                    writer.wake();
                }
            }
            handedOver = true;
        } finally {
            imageWanted |= !handedOver; // otherwise the frame would be missing without notice
            early.clear();
            laws.clear();
            rules.clear();
            earlyCount = 0;
        }
    }

    /**
     * Omits a frame from the journal. A later image makes the omitted frames unnecessary for a
     * restore.
     */
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
        entry.rules.addAll(rules);
        entry.events = world.events();
        entry.members = members;
        entry.allRules = allRules.get();
        boolean isRewound = changes.stream().anyMatch(WorldChange.Restored.class::isInstance);
        entry.begins = imageWanted || writer.beginsAnew() || world.changesLost() > 0 || isRewound;
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
            if (isRewound || lastImage < 0) {
                lastBeginning = frame;
            }
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
        } catch (RuntimeException failure) {
            // The engine may throw this exception if its process is being replaced.
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

    /**
     * Returns the ids of the agents' bodies, by agent, after an event such as a join or a leave.
     */
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
