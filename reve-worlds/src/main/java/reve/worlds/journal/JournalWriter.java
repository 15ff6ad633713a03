package reve.worlds.journal;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.util.HashSet;
import java.util.Queue;
import java.util.Set;
import java.util.concurrent.locks.LockSupport;
import java.util.function.Consumer;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawLibrary;

/** The thread that writes a journal: frames in groups, which the sink makes durable at once. */
final class JournalWriter {
    private static final long GROUP_NANOSECONDS = 100_000_000;
    private static final int GROUP_BYTES = 1 << 20;

    private final EntryRing ring;
    private final Queue<SimulationImage> rooms;
    private final JournalSink sink;
    private final Consumer<String> problems;
    private final ImageCodec images;
    private final FrameCodec frames;
    private final Set<String> libraries = new HashSet<>();
    private final ByteArrayOutputStream group = new ByteArrayOutputStream();
    private final Thread thread = Thread.ofPlatform().name("journal").unstarted(this::run);
    private long groupFirst;
    private long groupLast;
    private long groupBegan;
    /** False until an image is written: what there is has to begin with one. */
    private boolean begun;
    private volatile boolean ending;

    JournalWriter(WorldHeader header, int digestSize, EntryRing ring, Queue<SimulationImage> rooms,
            JournalSink sink, Consumer<String> problems) {
        this.ring = ring;
        this.rooms = rooms;
        this.sink = sink;
        this.problems = problems;
        images = new ImageCodec(header);
        frames = new FrameCodec(header, digestSize);
    }

    void start() {
        thread.start();
    }

    void wake() {
        LockSupport.unpark(thread);
    }

    boolean isWorking() {
        return thread.isAlive();
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
        while (true) {
            boolean last = ending; // asked first: nothing comes after it
            Entry entry = ring.peek();
            if (entry != null) {
                attempt(() -> take(entry));
                SimulationImage image = entry.image;
                ring.release();
                if (image != null) {
                    rooms.add(image);
                }
            } else if (last) {
                attempt(this::writeGroup);
                attempt(sink::close);
                return;
            } else {
                waitOrWrite();
            }
        }
    }

    private void waitOrWrite() {
        long due = group.size() == 0 ? Long.MAX_VALUE
                : groupBegan + GROUP_NANOSECONDS - System.nanoTime();
        if (due <= 0) {
            attempt(this::writeGroup);
        } else {
            LockSupport.parkNanos(this, due);
        }
    }

    private interface Step {
        void run() throws IOException;
    }

    /** What fails costs the journal up to the next image, and nothing else. */
    private void attempt(Step step) {
        try {
            step.run();
        } catch (IOException | RuntimeException | LinkageError | VirtualMachineError e) {
            group.reset();
            begun = false;
            problems.accept(String.valueOf(e.getMessage()));
        }
    }

    private void take(Entry entry) throws IOException {
        if (begun && !entry.begins) {
            addFrame(entry);
        }
        SimulationImage image = entry.image;
        if (image != null) {
            writeGroup();
            writeImage(image, entry);
        }
    }

    private void addFrame(Entry entry) throws IOException {
        for (LawChange change : entry.laws) {
            if (change instanceof LawChange.Loaded added) {
                writeLibrary(added.library());
            }
        }
        if (group.size() == 0) {
            groupFirst = entry.frame;
            groupBegan = System.nanoTime();
        }
        group.writeBytes(frames.write(entry));
        group.write('\n');
        groupLast = entry.frame;
        if (group.size() >= GROUP_BYTES || System.nanoTime() - groupBegan >= GROUP_NANOSECONDS) {
            writeGroup();
        }
    }

    private void writeGroup() throws IOException {
        if (group.size() > 0) {
            sink.write(new JournalRecord.Frames(groupFirst, groupLast, group.toByteArray()));
            group.reset();
        }
    }

    private void writeImage(SimulationImage image, Entry entry) throws IOException {
        for (LawLibrary library : image.physics().libraries()) {
            writeLibrary(library);
        }
        sink.write(new JournalRecord.Image(entry.frame, images.write(image, entry.members)));
        frames.begin();
        begun = true;
    }

    private void writeLibrary(LawLibrary library) throws IOException {
        if (!libraries.contains(library.sha256())) {
            sink.write(new JournalRecord.Library(library.sha256(), library.bytes()));
            libraries.add(library.sha256());
        }
    }
}
