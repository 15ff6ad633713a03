// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.core.file.RuleChanges;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawLibrary;

import java.io.IOException;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ConcurrentHashMap;
import java.util.concurrent.ScheduledThreadPoolExecutor;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;
import java.util.function.Supplier;
import java.util.regex.Pattern;

/**
 * The two threads that write a journal. The first thread appends each frame as soon as the world's
 * thread passes it. The second thread writes images and flushes data to the disk.
 */
final class JournalWriter {
    private static final int SPINS = 1_000;
    private static final long SYNC_MILLISECONDS = 100;
    private static final int LAST_IMAGE_TRIES = 3;

    /** Interval between two checks that the journal's file still exists at its path [ns]. */
    private static final long LOOK_NANOSECONDS = 1_000_000_000;

    private static final String NOTHING_KEPT = "; nothing is kept until an image can be written";
    private static final long BETWEEN_TRIES_NANOSECONDS = 200_000_000;

    /** Time after which the same failure is reported again [ns]. */
    private static final long AGAIN_NANOSECONDS = 60_000_000_000L;

    private static final Pattern NUMBER = Pattern.compile("[0-9]+");

    private final EntryRing ring;
    private final Queue<SimulationImage> rooms;
    private final Journal.Plan plan;
    private final JournalSink sink;
    private final Consumer<String> problems;
    private final ImageCodec images;
    private final FrameCodec frames;
    private final Thread thread = Thread.ofPlatform().name("journal").unstarted(this::run);
    private final ScheduledThreadPoolExecutor disk =
            new ScheduledThreadPoolExecutor(
                    1, Thread.ofPlatform().name("journal images").factory());
    private final AtomicBoolean syncDue = new AtomicBoolean();

    /** True after the first image was stored, because the journal must begin with an image. */
    private boolean begun;

    /**
     * Last frame that the journal can restore without a gap; -1 for none. Its final value is set
     * when the writer ends.
     */
    private long reached = -1;

    /**
     * Frame of the image with which the journal began. After a gap, it is the frame of the image
     * with which the journal resumed.
     */
    private long begunAt = -1;

    private boolean lastImageKept = true;
    private final AtomicBoolean beginsAnew = new AtomicBoolean();
    private long lookedNanos = System.nanoTime();

    /**
     * True from a failed write until the next image is stored. The sink accepts no frames during
     * this time.
     */
    private volatile boolean failing;

    /** True while the file is moved, removed or truncated and not yet replaced. */
    private boolean missing;

    /**
     * True if a write of the recording failed and the recording does not yet continue in another
     * file.
     */
    private volatile boolean refused;

    /** True after a report stated why the recording cannot continue in another file. */
    private boolean toldStay;

    /**
     * The time of the last report of each failure [ns]. The map is cleared when the journal is
     * complete again.
     */
    private final Map<String, Long> reported = new ConcurrentHashMap<>();

    /** Name of the file that replaces a lost one, for messages; empty if there is none. */
    private String place = "";

    /** The frames that a recording lacks. Set when the writer ends. */
    private Optional<Journal.Gap> gap = Optional.empty();

    private volatile boolean ending;
    private volatile @Nullable Throwable failure;

    JournalWriter(
            WorldHeader header,
            int digestSize,
            EntryRing ring,
            Queue<SimulationImage> rooms,
            Journal.Plan plan,
            JournalSink sink,
            Consumer<String> problems) {
        this.ring = ring;
        this.rooms = rooms;
        this.plan = plan;
        this.sink = sink;
        this.problems = problems;
        images = new ImageCodec(header);
        frames = new FrameCodec(header, digestSize);
        disk.setExecuteExistingDelayedTasksAfterShutdownPolicy(false);
    }

    void start() {
        thread.start();
        disk.scheduleWithFixedDelay(
                this::lookAtFiles, LOOK_NANOSECONDS, LOOK_NANOSECONDS, TimeUnit.NANOSECONDS);
    }

    private void lookAtFiles() {
        attempt(() -> sink.troubles().forEach(problems), "; the files are looked at again");
    }

    void wake() {
        LockSupport.unpark(thread);
    }

    /**
     * Returns false after the writer has ended, normally or by a failure. Entries that still wait
     * in the ring are then never written.
     */
    boolean isWorking() {
        return failure == null && thread.isAlive();
    }

    /**
     * Returns true once after a new file was begun, so that the next frame brings the image with
     * which the file must begin. For the world's thread only.
     */
    boolean beginsAnew() {
        return beginsAnew.get() && beginsAnew.getAndSet(false);
    }

    /**
     * Returns whether the last write failed and no image has been stored since. Frames then need
     * not wait for the disk, because none of them is written.
     */
    boolean isFailing() {
        return failing;
    }

    /** Returns why the writer ended or is about to end; empty unless it failed. */
    Optional<Throwable> failure() {
        return Optional.ofNullable(failure);
    }

    /**
     * Returns the last frame that the journal can restore without a gap; -1 for none. Valid after
     * the writer has ended.
     */
    long reached() {
        return reached;
    }

    /**
     * Returns the frames that a recording lacks, except those beyond its size limit. Valid after
     * the writer has ended.
     */
    Optional<Journal.Gap> gap() {
        return gap;
    }

    /**
     * Returns whether the final image is stored, or none was due. Valid after the writer has ended.
     */
    boolean isLastImageKept() {
        return lastImageKept && failure == null;
    }

    /** Waits until all passed entries are written and the sink is closed. */
    void end() {
        ending = true;
        wake();
        boolean interrupted = false;
        while (thread.isAlive()) {
            try {
                thread.join();
            } catch (InterruptedException e) {
                interrupted = true;
            }
        }
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
    }

    private void run() {
        try {
            writeAll();
        } catch (Throwable e) {
            // The method failure() passes the error to the world's thread.
            failure = e;
        } finally {
            disk.close();
            if (begun) {
                sink.missing()
                        .ifPresent(
                                trouble -> {
                                    problems.accept(
                                            trouble
                                                    + ";"
                                                    + " what was recorded is no longer there");
                                    gap =
                                            gap.or(
                                                    () ->
                                                            Optional.of(
                                                                    new Journal.Gap(
                                                                            reached - begunAt + 1,
                                                                            begunAt,
                                                                            reached)));
                                });
            }
            attempt(sink::close, "; what was written before is there");
        }
    }

    private void writeAll() {
        while (failure == null) {
            // This field is read before the ring, because no entry follows after it is set.
            boolean last = ending;
            Entry entry = ring.peek();
            if (entry != null) {
                lookAfterFile();
                take(entry);
                ring.release();
            } else if (last) {
                return;
            } else {
                waitForMore();
            }
        }
    }

    /**
     * Waits for the next entry. Spins briefly before it blocks, because in a fast world the next
     * entry arrives soon.
     */
    private void waitForMore() {
        for (int i = 0; i < SPINS && ring.peek() == null; i++) {
            Thread.onSpinWait();
        }
        if (ring.peek() == null) {
            LockSupport.park(this);
        }
    }

    /**
     * Begins a new file if the current one was moved, removed or truncated, because new data would
     * be lost.
     */
    private void lookAfterFile() {
        long now = System.nanoTime();
        if (!begun && !missing && !refused || now - lookedNanos < LOOK_NANOSECONDS) {
            return;
        }
        lookedNanos = now;
        if (refused) {
            beginAfterRefusal();
            return;
        }
        Optional<String> trouble = sink.missing();
        if (trouble.isEmpty() && !missing) {
            return;
        }
        begun = false;
        try {
            sink.beginAnew();
            missing = false;
            beginsAnew.set(true);
            problems.accept(
                    trouble.orElse("the recording was missing")
                            + "; a new recording begins there,"
                            + " which lacks the frames before it");
        } catch (IOException e) {
            if (!missing) {
                problems.accept(
                        trouble.orElse("the recording is missing")
                                + ", and no new recording can begin there: "
                                + reason(e)
                                + "; nothing is recorded until one can");
            }
            missing = true;
        }
    }

    /**
     * Begins a new file with an image, after a failed write, as soon as there is disk space for the
     * image.
     */
    private void beginAfterRefusal() {
        try {
            place = sink.beginAnew();
            missing = false;
            beginsAnew.set(true);
        } catch (IOException e) {
            if (!toldStay) {
                problems.accept("no other recording can begin: " + reason(e));
            }
            toldStay = true;
        }
    }

    private interface Step {
        void run() throws IOException;
    }

    /**
     * Runs a step of the work. Reports the reason and the consequence if the step fails, and
     * returns false. An Error, for example out of memory, is treated like a failure of the disk.
     */
    private boolean attempt(Step step, String consequence) {
        return attempt(step, () -> consequence);
    }

    private boolean attempt(Step step, Supplier<String> consequence) {
        try {
            step.run();
            return true;
        } catch (JournalSink.LostException lost) {
            failure = lost; // the listener of the sink has reported it
            return false;
        } catch (Throwable e) {
            if (e instanceof JournalSink.GapException) {
                beginsAnew.set(true);
            }
            if (!refused) {
                // The failure of a recording that stays refused was already reported.
                report(reason(e) + consequence.get());
            }
            return false;
        }
    }

    /** Reports a failure, unless the same failure was reported less than a minute ago. */
    private void report(String problem) {
        long now = System.nanoTime();
        String kind = NUMBER.matcher(problem).replaceAll("#"); // numbers differ each time
        Long before = reported.get(kind);
        if (before == null || now - before > AGAIN_NANOSECONDS) {
            reported.put(kind, now);
            problems.accept(problem);
        }
    }

    private static String reason(Throwable failure) {
        return failure instanceof IOException && failure.getMessage() != null
                ? failure.getMessage()
                : failure.toString();
    }

    /**
     * Writes an entry. The journal lacks all frames up to the next image if a frame cannot be
     * written.
     */
    private void take(Entry entry) {
        if (!entry.sessions.isEmpty()) {
            sink.note(entry.sessions);
        }
        if (begun && !entry.begins && !entry.last) {
            begun =
                    attempt(
                            () -> addFrame(entry),
                            () ->
                                    plan.imageFrames() == 0
                                            ? sink.hasItsLimit()
                                                    ? "; the recording ends before frame "
                                                            + entry.frame
                                                    : "; the frames from "
                                                            + entry.frame
                                                            + " on are not recorded, until a new "
                                                            + "recording can begin"
                                            : "; a crash before the next image loses the frames"
                                                    + " from "
                                                    + entry.frame
                                                    + " on");
            if (begun) {
                reached = entry.frame;
            } else {
                refused = isRecordingRefused();
            }
        }
        lastImageKept &= !entry.last || entry.image != null;
        if (entry.image != null) {
            SimulationImage image = entry.image;
            if (!attempt(() -> keepImage(entry, image), NOTHING_KEPT)) {
                begun = false;
                lastImageKept &= !entry.last;
            }
            if (begun && refused) {
                refused = false;
                toldStay = false;
                problems.accept(
                        (place.isEmpty()
                                        ? "the recording continues with frame " + entry.frame
                                        : "a new recording begins with frame "
                                                + entry.frame
                                                + " in "
                                                + place)
                                + gap.map(lack -> "; " + lack).orElse(""));
                place = "";
            } else if (!begun) {
                refused |= isRecordingRefused();
            }
        }
        failing = !begun;
        if (!begun && (refused || missing)) {
            gap =
                    Optional.of(
                            gap.map(lack -> lack.and(entry.frame))
                                    .orElseGet(() -> new Journal.Gap(1, entry.frame, entry.frame)));
        }
    }

    private boolean isRecordingRefused() {
        return plan.imageFrames() == 0 && !sink.hasItsLimit();
    }

    private void addFrame(Entry entry) throws IOException {
        for (LawChange change : entry.laws) {
            Optional<LawLibrary> brought = change.brought();
            if (brought.isPresent()) {
                sink.write(record(brought.get()));
            }
        }
        sink.write(new JournalRecord.Frame(entry.frame, frames.write(entry)));
        if (syncDue.compareAndSet(false, true)) {
            disk.schedule(this::sync, SYNC_MILLISECONDS, TimeUnit.MILLISECONDS);
        }
    }

    private void sync() {
        syncDue.set(false);
        attempt(sink::sync, "; a power failure may cost more than the last 0.1 s");
    }

    /**
     * Writes an image. Meanwhile the other thread continues to write frames. Only the first image
     * of a journal makes that thread wait.
     */
    private void keepImage(Entry entry, SimulationImage image) throws IOException {
        Map<String, Long> members = entry.members;
        RuleChanges rules = entry.allRules;
        int tries = entry.last ? LAST_IMAGE_TRIES : 1;
        String otherwise =
                begun && !entry.begins
                        ? "; the image before it and the frames since are there"
                        : NOTHING_KEPT;
        CompletableFuture<Boolean> kept;
        try {
            JournalSink.Place place = sink.place();
            frames.begin();
            kept =
                    CompletableFuture.supplyAsync(
                            () -> writeImage(image, members, rules, place, tries, otherwise), disk);
        } catch (Throwable e) {
            rooms.add(image); // writeImage() does this if it runs
            throw e;
        }
        if (entry.begins || entry.last || !begun) {
            boolean lacksFrames = !begun && begunAt >= 0 && plan.imageFrames() != 0;
            begun = kept.join();
            if (begun && lacksFrames) {
                reported.clear();
                problems.accept(
                        "the store is complete again from the image of frame "
                                + entry.frame
                                + " on");
            }
            lastImageKept &= begun || !entry.last;
            reached = begun ? entry.frame : reached;
            begunAt = entry.frame;
        }
    }

    private boolean writeImage(
            SimulationImage image,
            Map<String, Long> members,
            RuleChanges rules,
            JournalSink.Place place,
            int tries,
            String otherwise) {
        try {
            Step step =
                    () ->
                            write(
                                    place,
                                    image.physics().libraries().stream()
                                            .map(JournalWriter::record)
                                            .toList(),
                                    new JournalRecord.Image(
                                            image.frame(), images.write(image, members, rules)));
            boolean done = attempt(step, otherwise);
            for (int i = 1; !done && i < tries; i++) {
                LockSupport.parkNanos(BETWEEN_TRIES_NANOSECONDS);
                done = attempt(step, otherwise);
            }
            return done;
        } finally {
            rooms.add(image);
        }
    }

    private void write(
            JournalSink.Place place,
            List<JournalRecord.Library> libraries,
            JournalRecord.Image image)
            throws IOException {
        try {
            place.write(libraries, image);
        } catch (JournalSink.BegunAnewException e) {
            problems.accept(
                    e.getMessage() + "; it continues with the image of frame " + image.frame());
            place.write(libraries, image);
        }
    }

    private static JournalRecord.Library record(LawLibrary library) {
        return new JournalRecord.Library(library.sha256(), library.bytes());
    }
}
