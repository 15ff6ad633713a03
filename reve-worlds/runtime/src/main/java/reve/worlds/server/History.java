// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.image.CorruptException;
import reve.core.image.Trees;
import reve.core.world.WorldPrototype;
import reve.core.world.WorldSnapshot;
import reve.pe.PhysicsException;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.RunLog;
import reve.worlds.journal.StoreContents;

import tools.jackson.databind.JsonNode;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Iterator;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The states of a recording or a store, frame by frame. Each frame is repeated and compared with
 * the journal. Therefore a state that differs from the recorded one is never returned. For one
 * thread.
 */
public final class History implements AutoCloseable {
    private static final byte[] DATABASE = "SQLite format 3\0".getBytes(StandardCharsets.US_ASCII);

    private final Path file;
    private final Replay replay;
    private final Iterator<JournalRecord> records;
    private final RunLog.@Nullable Reader recording;
    private final long last;
    private long first = -1;
    private List<Happening> happenings = List.of();

    /**
     * An event that a journal contains.
     *
     * @param fields text, numbers and truth values by name, in the order of the event
     */
    public record Happening(String type, Map<String, Object> fields) {}

    private History(
            Path file,
            Replay replay,
            Iterator<JournalRecord> records,
            RunLog.@Nullable Reader recording,
            long last) {
        this.file = file;
        this.replay = replay;
        this.records = records;
        this.recording = recording;
        this.last = last;
    }

    /** Returns whether a file begins like a recording or a store. */
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
     * Opens a recording, or a store that no server uses. The file is not changed.
     *
     * @param laws decides which of the journal's law libraries may be opened
     * @throws IOException if the file cannot be read
     * @throws CorruptException if it is no recording and no store, or a store is damaged
     */
    public static History open(Path file, LawPath laws) throws IOException {
        if (isStore(file)) {
            StoreContents contents = StoreContents.read(file);
            contents.requireWhole();
            LawFiles found = new LawFiles(laws, _ -> {});
            List<JournalRecord> records = contents.records();
            return new History(
                    file,
                    new Replay(Optional.empty(), Optional.empty(), Pacing.FAST, laws, found::find),
                    records.iterator(),
                    null,
                    contents.frame());
        }
        RunLog.Reader recording = RunLog.open(file);
        try {
            return new History(
                    file,
                    new Replay(Optional.empty(), Pacing.FAST, laws),
                    recording,
                    recording,
                    recording.lastFrame());
        } catch (IOException e) {
            recording.close();
            throw e;
        }
    }

    /**
     * Makes the next frame. The first frame is the frame of the journal's first image (a complete
     * state).
     *
     * @return false if the journal has ended
     * @throws CorruptException if the journal is damaged, or the repeated frame differs from the
     *     recorded one
     * @throws PhysicsException if a law may not be opened, or does not load
     */
    public boolean next() {
        while (records.hasNext()) {
            JournalRecord record = records.next();
            take(record);
            first = first < 0 ? replay.frame() : first;
            switch (record) {
                case JournalRecord.Library _ -> {}
                case JournalRecord.Image _ -> {
                    replay.publish();
                    happenings = List.of();
                    return true;
                }
                case JournalRecord.Frame frame -> {
                    happenings = happenings(frame);
                    return true;
                }
            }
        }
        return false;
    }

    private void take(JournalRecord record) {
        try {
            replay.take(record);
        } catch (CorruptException meaningless) {
            throw new CorruptException(place() + meaningless.getMessage(), meaningless);
        } catch (PhysicsException refused) {
            throw new PhysicsException(refused.status(), place() + refused.getMessage());
        }
        replay.divergence()
                .ifPresent(
                        found -> {
                            throw new CorruptException(
                                    file
                                            + ": the repeated run differs from the recorded one: "
                                            + found.message()
                                            + "; replay it with the version of REVE that recorded"
                                            + " it");
                        });
    }

    private String place() {
        return file + (replay.frame() < 0 ? "" : ", after frame " + replay.frame()) + ": ";
    }

    private static List<Happening> happenings(JournalRecord.Frame frame) {
        List<Happening> all = new ArrayList<>();
        for (JsonNode event : Trees.listIfAny(Trees.read(frame.json()), "events")) {
            Map<String, Object> fields = new LinkedHashMap<>();
            Trees.field(event, "fields")
                    .properties()
                    .forEach(field -> fields.put(field.getKey(), plain(field.getValue())));
            all.add(new Happening(Trees.text(event, "type"), fields));
        }
        return all;
    }

    private static Object plain(JsonNode value) {
        if (value.isBoolean()) {
            return value.asBoolean();
        }
        return value.isNumber() ? value.numberValue() : value.asString();
    }

    /** Returns the state at the end of the current frame; the caller closes it. */
    public WorldSnapshot snapshot() {
        return replay.simulation().snapshots().acquireLatest().orElseThrow();
    }

    /** Returns the recorded events of the current frame, in order. */
    public List<Happening> happenings() {
        return happenings;
    }

    /** Returns the name of the world. Valid after the first {@link #next()}. */
    public String world() {
        return replay.simulation().description().name();
    }

    /** Returns the properties of the world's items. Valid after the first {@link #next()}. */
    public WorldPrototype prototype() {
        return replay.simulation().description().prototype();
    }

    /** Returns the frame rate of the world. Valid after the first {@link #next()}. */
    public Timing timing() {
        return replay.simulation().description().timing();
    }

    /** Returns the number of the current frame; -1 before the first {@link #next()}. */
    public long frame() {
        return replay.frame();
    }

    /**
     * Returns the fraction of the frames that was made, from 0 to 1. Used for progress messages.
     */
    public double part() {
        return last <= first ? 1 : Math.min(1, (double) (frame() - first) / (last - first));
    }

    /** Returns whether a recording ends within a record. Valid after its last frame. */
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
