// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import org.jspecify.annotations.Nullable;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.security.SecureRandom;
import java.util.List;
import java.util.TreeMap;
import java.util.stream.Stream;

/**
 * The files beside a store that contain its frames (STORE-frames-1 and so on), and the manifest,
 * which lists their content. A new file begins with each image, and names the previous file. Files
 * before the oldest image are removed.
 */
final class FrameFiles {
    /**
     * Suffix of the longest file name. This number is reached after 30 years at ten images per
     * second.
     */
    static final String LONGEST_ENDING = "-frames-9999999999";

    private static final SecureRandom IDS = new SecureRandom();

    private final Path store;
    private Manifest.Claim claim;
    private long number;
    private long id;
    private volatile @Nullable Manifest manifest;
    private volatile RunLog.@Nullable Writer current;

    /** The file before the current one, which may not be flushed to the disk yet. */
    private volatile RunLog.@Nullable Writer previous;

    /**
     * Creates the object for the files of a store. No file is written before {@link #next}.
     *
     * @param claim initial content of the manifest
     * @param number the number of the newest existing file; 0 if there is none
     * @param id the identity of that file
     */
    FrameFiles(Path store, Manifest.Claim claim, long number, long id) {
        this.store = store.toAbsolutePath();
        this.claim = claim;
        this.number = number;
        this.id = id;
    }

    /** The file before the newest one. It receives no more frames. */
    record Finished(RunLog.@Nullable Writer file) implements AutoCloseable {
        /** Closes the file after its data was flushed to the disk. Idempotent. */
        @Override
        public void close() throws IOException {
            if (file != null && file.isOpen()) {
                try (RunLog.Writer closing = file) {
                    closing.force();
                }
            }
        }
    }

    /** Returns the number of the file that receives the next record. */
    long number() {
        return number;
    }

    /** Begins another file, and returns the previous one. */
    Finished next() throws IOException {
        Manifest listed = manifest();
        long nextId = IDS.nextLong();
        RunLog.Writer next =
                new RunLog.Writer(
                        path(store, number + 1),
                        new RunLog.Link(claim.store(), number + 1, nextId, id));
        try {
            listed.begin(number + 1, nextId);
        } catch (IOException e) {
            next.close();
            throw e;
        }
        number++;
        id = nextId;
        Finished finished = new Finished(current);
        previous = current;
        current = next;
        return finished;
    }

    /** Appends a record to the newest file. */
    void write(JournalRecord record) throws IOException {
        RunLog.Writer file = current;
        Manifest listed = manifest;
        if (file == null || listed == null) {
            throw new IllegalStateException("a frame before the first image");
        }
        file.write(record);
        if (record instanceof JournalRecord.Frame frame) {
            listed.reach(frame.frame());
        }
    }

    /**
     * Flushes the manifest before an image is committed to the database. For any thread, after the
     * first {@link #next}.
     */
    void forceManifest() throws IOException {
        Manifest listed = manifest;
        if (listed != null) {
            listed.force();
        }
    }

    /**
     * Records in the manifest that an image was committed to the database. For any thread, after
     * the first {@link #next}.
     */
    void keep(long image, long frame, long sum) throws IOException {
        Manifest listed = manifest;
        if (listed != null) {
            listed.keep(image, frame, sum);
        }
    }

    /**
     * Flushes the frames to the disk, so that they survive a power failure. Flushes the end of the
     * previous file first, because later frames cannot be used without earlier ones. For any thread
     * except the thread that closes the current file.
     */
    void force() throws IOException {
        RunLog.Writer before = previous;
        RunLog.Writer file = current;
        if (before != null && before.isOpen()) {
            try {
                before.force();
            } catch (IOException e) {
                if (before.isOpen()) {
                    // The failure is ignored for a closed file, because it was flushed before.
                    throw e;
                }
            }
        }
        if (file != null) {
            file.force();
        }
    }

    /** Closes the newest file and the manifest. */
    void close() throws IOException {
        try (Manifest _ = manifest;
                Finished _ = new Finished(current)) {
            current = null;
            manifest = null;
        }
    }

    /** Removes the files with numbers below {@code kept}. */
    void dropBefore(long kept) throws IOException {
        for (Path file : present(store).headMap(kept).values()) {
            Files.deleteIfExists(file);
        }
    }

    /**
     * Returns a message for each of the newest file and the manifest that was moved, removed or
     * truncated. For any thread except the thread that closes files.
     */
    List<String> troubles() {
        Manifest listed = manifest;
        RunLog.Writer file = current;
        List<String> found =
                Stream.of(
                                listed == null ? "" : listed.trouble(),
                                file == null ? "" : file.trouble())
                        .filter(each -> !each.isEmpty())
                        .toList();
        // The result of this check is not valid if the manifest or the file was replaced meanwhile.
        // It is then discarded, and the next check finds any problem.
        return listed == manifest && file == current ? found : List.of();
    }

    /** Returns the manifest. Creates a new one if its file is missing. */
    private Manifest manifest() throws IOException {
        Manifest now = manifest;
        if (now == null || !now.trouble().isEmpty()) {
            if (now != null) {
                claim = now.claim();
                manifest = null; // a later call creates it if this call fails
                now.close();
            }
            now = new Manifest(store, claim);
            manifest = now;
        }
        return now;
    }

    static Path path(Path store, long which) {
        return store.resolveSibling(store.getFileName() + "-frames-" + which);
    }

    /** Returns the existing files of frames, by number. */
    static TreeMap<Long, Path> present(Path store) throws IOException {
        String prefix = store.getFileName() + "-frames-";
        var files = new TreeMap<Long, Path>();
        try (Stream<Path> siblings = Files.list(store.toAbsolutePath().getParent())) {
            siblings.forEach(
                    file -> {
                        String name = file.getFileName().toString();
                        String digits =
                                name.startsWith(prefix) ? name.substring(prefix.length()) : "";
                        if (digits.matches("[1-9][0-9]{0,17}")) {
                            files.put(Long.parseLong(digits), store.resolveSibling(name));
                        }
                    });
        }
        return files;
    }
}
