package reve.worlds.journal;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.TreeMap;
import java.util.function.Consumer;
import java.util.stream.Stream;
import org.jspecify.annotations.Nullable;
import reve.core.store.CorruptException;

/**
 * The files beside a store that hold its frames, STORE-frames-1 and so on: with each image a new
 * one begins, and those before the oldest image are removed.
 */
final class FrameFiles {
    private final Path store;
    private final String prefix;
    private long number;
    private volatile RunLog.@Nullable Writer current;

    /** @param number of a file that is to be behind all there are, at least */
    FrameFiles(Path store, long number) throws IOException {
        this.store = store.toAbsolutePath();
        prefix = store.getFileName() + "-frames-";
        TreeMap<Long, Path> present = present();
        this.number = present.isEmpty() ? number : Math.max(number, present.lastKey());
    }

    /** A file that later frames do not go to any more. */
    record Finished(RunLog.@Nullable Writer file) implements AutoCloseable {
        /** Waits until all of it outlives a power failure. May be called twice. */
        @Override
        public void close() throws IOException {
            if (file != null && file.isOpen()) {
                try (RunLog.Writer closing = file) {
                    closing.force();
                }
            }
        }
    }

    /** Of the file that the next record goes to. */
    long number() {
        return number;
    }

    /** Begins another file, when the next record is written. Gives the one before it. */
    Finished next() {
        Finished finished = new Finished(current);
        current = null;
        number++;
        return finished;
    }

    void write(JournalRecord record) throws IOException {
        RunLog.Writer file = current;
        if (file == null) {
            file = new RunLog.Writer(path(number), Long.MAX_VALUE);
            current = file;
        }
        file.write(record);
    }

    /** Waits until the current file outlives a power failure. Any thread but that closes files. */
    void force() throws IOException {
        RunLog.Writer file = current;
        if (file != null) {
            file.force();
        }
    }

    /**
     * Hands over the records of the files from one number on, up to the first that is damaged.
     *
     * @param problems told of damage
     */
    void read(long from, Consumer<JournalRecord> into, Consumer<String> problems)
            throws IOException {
        for (Path file : present().tailMap(from).values()) {
            if (Files.size(file) < RunLog.EMPTY_BYTES) {
                continue; // the process ended as it began this one
            }
            try (RunLog.Reader records = RunLog.open(file)) {
                records.forEachRemaining(into);
            } catch (CorruptException e) {
                problems.accept(e.getMessage() + "; the world resumes before that");
                return;
            }
        }
    }

    /** Removes the files before a number. */
    void dropBefore(long kept) throws IOException {
        for (Path file : present().headMap(kept).values()) {
            Files.deleteIfExists(file);
        }
    }

    private Path path(long which) {
        return store.resolveSibling(prefix + which);
    }

    private TreeMap<Long, Path> present() throws IOException {
        var files = new TreeMap<Long, Path>();
        try (Stream<Path> siblings = Files.list(store.getParent())) {
            siblings.forEach(file -> {
                String name = file.getFileName().toString();
                String digits = name.startsWith(prefix) ? name.substring(prefix.length()) : "";
                if (digits.matches("[1-9][0-9]{0,17}")) {
                    files.put(Long.parseLong(digits), file);
                }
            });
        }
        return files;
    }
}
