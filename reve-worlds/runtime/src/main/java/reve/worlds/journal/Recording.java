// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.disk.OwnedFile;

import java.io.IOException;
import java.io.InputStream;
import java.nio.channels.FileChannel;
import java.nio.file.AccessDeniedException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Optional;
import java.util.stream.IntStream;

/**
 * A recording in progress, in a file that is locked against other processes. An older recording at
 * the same path is renamed.
 */
public final class Recording implements JournalSink {
    private final RecordingPlan plan;
    private final Path file;
    private Optional<Path> older = Optional.empty();
    private OwnedFile owned;
    private RunLog.Writer writer;

    /**
     * Begins a recording. Renames an existing recording to {@code FILE.1}, unless it contains
     * nothing to replay.
     *
     * @throws IOException if the file cannot be written, is in use by another process, or is not a
     *     recording
     */
    public Recording(RecordingPlan plan) throws IOException {
        this.plan = plan;
        this.file = plan.file();
        owned = open();
        writer = writer();
    }

    private OwnedFile open() throws IOException {
        // This check comes before the lock is taken. The check reads and closes the file, and
        // closing it would release the lock.
        requireRecording(file);
        try {
            OwnedFile.requireName(file, "." + plan.keep());
            OwnedFile found = OwnedFile.open(file);
            if (!Files.isRegularFile(file) || found.channel().size() <= RunLog.EMPTY_BYTES) {
                return found;
            }
            try (found) {
                older = Optional.of(rotated());
            }
            return OwnedFile.open(file);
        } catch (IOException e) {
            throw FileTrouble.of(file, "opened", e);
        }
    }

    /**
     * Renames the older recordings. The lock is kept until the new file exists, so that two servers
     * never rename at the same time.
     */
    private Path rotated() throws IOException {
        try {
            return OwnedFile.rotate(file, plan.keep(), Recording::requireRecording);
        } catch (IOException e) {
            throw new IOException(
                    "it holds a recording, which could not be moved to "
                            + OwnedFile.older(file, 1)
                            + ": "
                            + FileTrouble.reason(file, e),
                    e);
        }
    }

    private RunLog.Writer writer() throws IOException {
        try {
            FileChannel empty = owned.channel();
            if (Files.isRegularFile(file)) {
                empty.truncate(0);
            }
            return new RunLog.Writer(file, empty, plan.maxBytes());
        } catch (IOException e) {
            owned.close();
            throw e;
        }
    }

    /**
     * Refuses a file that is not a recording, for example a store, a world file or a picture named
     * by mistake.
     */
    private static void requireRecording(Path named) throws IOException {
        if (!Files.isRegularFile(named) || Files.size(named) == 0) {
            return;
        }
        try (InputStream held = Files.newInputStream(named)) {
            if (!RunLog.isRecording(held)) {
                throw new IOException(
                        named
                                + " is there already and holds no recording; name "
                                + "another file, or remove it");
            }
        } catch (AccessDeniedException e) {
            throw FileTrouble.of(named, "read", e);
        }
    }

    /** Returns the path to which the previous recording was renamed, if there was one. */
    public Optional<Path> older() {
        return older;
    }

    @Override
    public void write(JournalRecord record) throws IOException {
        writer.write(record);
    }

    @Override
    public Place place() {
        return (libraries, image) -> writer.write(libraries, image);
    }

    @Override
    public void sync() {
        // This method does nothing, because a recording need not survive a power failure.
    }

    @Override
    public Optional<String> missing() {
        String trouble = owned.trouble(writer.written());
        return trouble.isEmpty() ? Optional.empty() : Optional.of(file + " " + trouble);
    }

    @Override
    public boolean hasItsLimit() {
        return writer.hasItsLimit();
    }

    @Override
    public String beginAnew() throws IOException {
        if (owned.isInPlace()) {
            boolean wasCut = Files.size(file) < writer.written();
            if (!wasCut) {
                requireRoomForOlder();
            }
            owned.close(); // this releases the lock of the process
            if (wasCut) {
                emptyUnlessRecording();
            }
        }
        OwnedFile fresh = open();
        owned.close();
        owned = fresh;
        writer = writer();
        return file + older.map(part -> ", the recording before it is " + part).orElse("");
    }

    /**
     * Empties a file that another program has truncated. Keeps the file if it still begins like a
     * recording. Without its beginning, its records cannot be replayed.
     */
    private void emptyUnlessRecording() throws IOException {
        try (InputStream held = Files.newInputStream(file)) {
            if (RunLog.isRecording(held)) {
                return;
            }
        }
        try (OwnedFile cut = OwnedFile.open(file)) {
            cut.channel().truncate(0);
        }
    }

    /**
     * Throws an exception if renaming would delete an older recording. Otherwise a disk that fills
     * up repeatedly would cause the deletion of all older recordings.
     */
    private void requireRoomForOlder() throws IOException {
        if (Files.size(file) > RunLog.EMPTY_BYTES
                && IntStream.rangeClosed(1, plan.keep())
                        .allMatch(i -> Files.exists(OwnedFile.older(file, i)))) {
            throw new IOException(
                    file
                            + " has "
                            + plan.keep()
                            + " older files, of which none is "
                            + "given up for a part of a recording; move some away");
        }
    }

    @Override
    public void close() throws IOException {
        writer.close();
    }
}
