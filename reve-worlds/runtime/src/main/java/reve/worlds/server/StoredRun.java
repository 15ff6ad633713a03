// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.file.WorldDescription;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.StoreReading;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.Iterator;
import java.util.Optional;

/**
 * The records of a recording or a store, and the replay that repeats them. Nothing is changed. For
 * one thread.
 */
public final class StoredRun implements Iterator<JournalRecord>, AutoCloseable {
    private static final byte[] DATABASE = "SQLite format 3\0".getBytes(StandardCharsets.US_ASCII);

    private final String name;
    private final LawPath laws;
    private final Replay replay;
    private final Iterator<JournalRecord> records;
    private final RunLog.@Nullable Reader recording;
    private final long lastFrame;

    private StoredRun(
            String name,
            LawPath laws,
            Replay replay,
            Iterator<JournalRecord> records,
            RunLog.@Nullable Reader recording,
            long lastFrame) {
        this.name = name;
        this.laws = laws;
        this.replay = replay;
        this.records = records;
        this.recording = recording;
        this.lastFrame = lastFrame;
    }

    /** Returns whether the beginning of a file shows that it is a recording or a store. */
    public static boolean isOne(Path file) throws IOException {
        return isStore(file) || isRecording(file);
    }

    private static boolean isRecording(Path file) throws IOException {
        if (!Files.isRegularFile(file)) {
            return false;
        }
        try (InputStream in = Files.newInputStream(file)) {
            return RunLog.isRecording(in);
        }
    }

    private static boolean isStore(Path file) throws IOException {
        if (!Files.isRegularFile(file)) {
            return false;
        }
        try (InputStream in = Files.newInputStream(file)) {
            return Arrays.equals(in.readNBytes(DATABASE.length), DATABASE);
        }
    }

    /**
     * Opens a recording, or a store that no server uses.
     *
     * @param laws decides which of the journal's law libraries may be opened
     * @throws IOException if the file cannot be read
     * @throws CorruptException if it is no recording and no store, or a store is damaged
     */
    public static StoredRun open(Path file, LawPath laws) throws IOException {
        return open(file, laws, Optional.empty(), Optional.empty());
    }

    /**
     * Opens a recording or a store like {@link #open(Path, LawPath)}.
     *
     * @param worldFile the world file of the run, which has the parts that a journal does not
     *     contain: camera, agents and rules
     * @param folder the folder of the world's meshes and textures; if empty, the folder that the
     *     journal names
     */
    public static StoredRun open(
            Path file, LawPath laws, Optional<WorldDescription> worldFile, Optional<Path> folder)
            throws IOException {
        if (isStore(file)) {
            return open(new StoreAddress.InFile(file), laws, worldFile, folder);
        }
        RunLog.Reader recording = RunLog.open(file);
        try {
            return new StoredRun(
                    file.toString(),
                    laws,
                    new Replay(worldFile, folder, Pacing.FAST, laws, _ -> null),
                    recording,
                    recording,
                    recording.lastFrame());
        } catch (IOException e) {
            recording.close();
            throw e;
        }
    }

    /**
     * Opens a store, with all frames that it contains.
     *
     * @param folder the folder of the world's meshes and textures; if empty, the folder that the
     *     store names
     * @param laws decides which of the store's law libraries may be opened
     * @throws IOException if the store cannot be read
     * @throws CorruptException if it is no store, or is damaged
     */
    public static StoredRun open(StoreAddress store, Optional<Path> folder, LawPath laws)
            throws IOException {
        return open(store, laws, Optional.empty(), folder);
    }

    private static StoredRun open(
            StoreAddress store,
            LawPath laws,
            Optional<WorldDescription> worldFile,
            Optional<Path> folder)
            throws IOException {
        StoreReading contents = store.history();
        contents.requireWhole();
        LawFiles found = new LawFiles(laws, _ -> {});
        return new StoredRun(
                contents.name(),
                laws,
                new Replay(worldFile, folder, Pacing.FAST, laws, found::find),
                contents.records().iterator(),
                null,
                contents.frame());
    }

    /** Returns the recording or the store, for messages. */
    public String name() {
        return name;
    }

    /** Returns what decides which of the law libraries may be opened. */
    LawPath laws() {
        return laws;
    }

    /** Returns the replay, which has applied no record yet. It belongs to this object. */
    public Replay replay() {
        return replay;
    }

    @Override
    public boolean hasNext() {
        return records.hasNext();
    }

    @Override
    public JournalRecord next() {
        return records.next();
    }

    /** Returns the last frame. */
    public long lastFrame() {
        return lastFrame;
    }

    /** Returns whether a recording ends within a record. Valid after its last record. */
    public boolean wasCut() {
        return recording != null && recording.wasCut();
    }

    @Override
    public void close() throws IOException {
        replay.close();
        if (recording != null) {
            recording.close();
        }
    }
}
