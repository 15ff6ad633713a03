// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawLibrary;

import java.io.IOException;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Queue;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.ScheduledThreadPoolExecutor;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;
import java.util.function.Supplier;

/**
 * Writes a journal on two threads: one that adds each frame as soon as it is handed over, and one
 * that keeps the images and waits for the disk, which both take their time.
 */
final class JournalWriter {
    private static final int SPINS = 1_000;
    private static final long SYNC_MILLISECONDS = 100;
    private static final int LAST_IMAGE_TRIES = 3;

    /** Time between two looks whether the file is still in its place [ns]. */
    private static final long LOOK_NANOSECONDS = 1_000_000_000;

    private static final String NOTHING_KEPT = "; nothing is kept until an image can be written";
    private static final long BETWEEN_TRIES_NANOSECONDS = 200_000_000;

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

    /** False until an image is kept: what there is has to begin with one. */
    private boolean begun;

    /** Frame that what is kept leads to without a gap, -1 for none. Final when the writer ends. */
    private long reached = -1;

    /** Frame of the image that began it last. */
    private long begunAt = -1;

    private boolean lastImageKept = true;
    private final AtomicBoolean beginsAnew = new AtomicBoolean();
    private long lookedNanos = System.nanoTime();

    /** The file was moved or removed, and there is no other one in its place yet. */
    private boolean missing;

    /** A recording could not be written, and does not go on yet in another file. */
    private volatile boolean refused;

    /** Whether it was told why it cannot go on in another file. */
    private boolean toldStay;

    /** Where one has begun, for people; empty if none has. */
    private String place = "";

    /** Frames that a recording lacks. Final when the writer ends. */
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

    /** False when it has ended, by a failure perhaps: what waits in the ring then stays there. */
    boolean isWorking() {
        return failure == null && thread.isAlive();
    }

    /** True once after a new file has begun, which is useless without an image. World's thread. */
    boolean beginsAnew() {
        return beginsAnew.get() && beginsAnew.getAndSet(false);
    }

    /** Why it has ended, unless it was told to. */
    Optional<Throwable> failure() {
        return Optional.ofNullable(failure);
    }

    /** After the end: the frame that what is kept leads to without a gap, -1 for none. */
    long reached() {
        return reached;
    }

    /** After the end: the frames that a recording lacks, but for those beyond its limit. */
    Optional<Journal.Gap> gap() {
        return gap;
    }

    /** After the end: whether the image of the end is kept, if there was to be one. */
    boolean isLastImageKept() {
        return lastImageKept && failure == null;
    }

    /** Waits until everything that was handed over is written and the sink is closed. */
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
        } catch (Throwable e) { // the world's thread asks for it
            failure = e;
        } finally {
            disk.close();
            if (begun) {
                sink.missing()
                        .ifPresent(
                                file -> {
                                    problems.accept(
                                            file
                                                    + " was moved or removed;"
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
        while (true) {
            boolean last = ending; // asked first: nothing comes after it
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
     * Looks for a while before it sleeps: where nothing paces the world, the next is soon there.
     */
    private void waitForMore() {
        for (int i = 0; i < SPINS && ring.peek() == null; i++) {
            Thread.onSpinWait();
        }
        if (ring.peek() == null) {
            LockSupport.park(this);
        }
    }

    /** A file that was moved or removed takes what is written along: begins another one. */
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
        Optional<Path> file = sink.missing();
        if (file.isEmpty() && !missing) {
            return;
        }
        begun = false;
        try {
            sink.beginAnew();
            missing = false;
            beginsAnew.set(true);
            problems.accept(
                    file.map(Path::toString).orElse("the recording")
                            + " was moved or removed; a new recording begins there,"
                            + " which lacks the frames before it");
        } catch (IOException e) {
            if (!missing) {
                problems.accept(
                        file.map(Path::toString).orElse("the recording")
                                + " was moved or removed, and no new recording can begin there: "
                                + reason(e)
                                + "; nothing is recorded until one can");
            }
            missing = true;
        }
    }

    /** A new file, which begins with an image, as soon as there is room for one. */
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
     * Whether it could be done; if not, somebody is told why, and what follows from it. An Error,
     * as for want of memory, costs no more than a disk that refuses.
     */
    private boolean attempt(Step step, String consequence) {
        return attempt(step, () -> consequence);
    }

    private boolean attempt(Step step, Supplier<String> consequence) {
        try {
            step.run();
            return true;
        } catch (Throwable e) {
            if (!refused) { // else told before
                problems.accept(reason(e) + consequence.get());
            }
            return false;
        }
    }

    private static String reason(Throwable failure) {
        return failure instanceof IOException && failure.getMessage() != null
                ? failure.getMessage()
                : failure.toString();
    }

    /** A frame that cannot be written costs the journal up to the next image, and nothing else. */
    private void take(Entry entry) {
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
                                        ? "the recording goes on with frame " + entry.frame
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
            if (change instanceof LawChange.Loaded added) {
                sink.write(record(added.library()));
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

    /** The frames go on meanwhile, unless they have nothing else to begin with. */
    private void keepImage(Entry entry, SimulationImage image) throws IOException {
        Map<String, Long> members = entry.members;
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
                            () -> writeImage(image, members, place, tries, otherwise), disk);
        } catch (Throwable e) {
            rooms.add(image); // else given back when it is written
            throw e;
        }
        if (entry.begins || entry.last || !begun) {
            begun = kept.join();
            lastImageKept &= begun || !entry.last;
            reached = begun ? entry.frame : reached;
            begunAt = entry.frame;
        }
    }

    private boolean writeImage(
            SimulationImage image,
            Map<String, Long> members,
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
                                            image.frame(), images.write(image, members)));
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
                    e.getMessage() + "; it goes on with the image of frame " + image.frame());
            place.write(libraries, image);
        }
    }

    private static JournalRecord.Library record(LawLibrary library) {
        return new JournalRecord.Library(library.sha256(), library.bytes());
    }
}
