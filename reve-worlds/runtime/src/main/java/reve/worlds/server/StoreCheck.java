// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import org.jspecify.annotations.Nullable;

import reve.core.disk.Reason;
import reve.core.frame.Pacing;
import reve.core.image.CorruptException;
import reve.pe.PhysicsException;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.JournalSink;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.StoreContents;
import reve.worlds.journal.StoreReading;

import java.io.IOException;
import java.nio.file.FileAlreadyExistsException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.stream.Stream;

/**
 * The result of checking a store by repeating its frames, and the repair of a store. For one
 * thread. No other process may have a store in files open.
 *
 * @param store the checked store
 * @param isWhole whether no data is lost
 * @param frame the frame from which a world can resume; -1 for none
 * @param knownFrame newest frame that the store is known to have contained
 * @param stateHash the hash of the world's state at {@code frame}
 * @param problems damaged or missing parts, one line each
 */
public record StoreCheck(
        String store,
        boolean isWhole,
        long frame,
        long knownFrame,
        long stateHash,
        List<String> problems) {
    /** The frame before which a replay ended early, and the reason. */
    record End(long frame, String reason) {}

    /** The result of replaying a store. */
    private record Made(StoreReading contents, LawFiles laws, StoreCheck check) {}

    /**
     * Checks a store without changing it.
     *
     * @param laws search path for replacements of damaged laws; it also decides which of the
     *     store's laws may be opened
     * @throws CorruptException if it is not a store
     * @throws IOException if it cannot be read, or another process has it open
     * @throws PhysicsException if a law of the store may not be opened
     */
    public static StoreCheck of(StoreAddress store, LawPath laws) throws IOException {
        return of(store, Optional.empty(), laws);
    }

    /**
     * Checks a store whose world has its files elsewhere.
     *
     * @param folder the folder of the world's meshes and textures; if empty, the folder that the
     *     store names
     */
    public static StoreCheck of(StoreAddress store, Optional<Path> folder, LawPath laws)
            throws IOException {
        return made(contents(store), folder, laws).check();
    }

    /**
     * Replaces a damaged store by a complete one that contains the recoverable frames. Moves the
     * damaged files unchanged to the folder STORE.damaged-N. A complete store stays unchanged.
     *
     * @return the result of the check, and the folder if the store was repaired
     * @throws CorruptException if nothing can be recovered; no file is changed
     * @throws IOException if a file cannot be read, written or moved; all changes are undone
     */
    public static Map.Entry<StoreCheck, Optional<Path>> repair(Path store, LawPath laws)
            throws IOException {
        StoreContents found = StoreContents.read(store);
        Made made = made(required(found), Optional.empty(), laws);
        if (made.check().problems().isEmpty()) {
            return Map.entry(made.check(), Optional.empty());
        }
        if (made.check().frame() < 0) {
            throw new CorruptException(
                    store
                            + ": nothing can be recovered: "
                            + String.join("; ", made.check().problems())
                            + " (nothing was changed)");
        }
        int number = StoreContents.setAside(store).size() + 1;
        while (Files.exists(store.resolveSibling(store.getFileName() + ".damaged-" + number))) {
            number++;
        }
        Path aside =
                Files.createDirectory(
                        store.resolveSibling(store.getFileName() + ".damaged-" + number));
        Path place = Files.createDirectory(aside.resolve(StoreContents.REPAIRED));
        Path repaired = place.resolve(store.getFileName());
        try {
            write(made, repaired);
            Map<Path, Path> moves = new LinkedHashMap<>();
            for (Path file : found.files()) {
                moves.put(file, aside.resolve(file.getFileName()));
            }
            // The database is moved as the last file, because servers refuse the store until its
            // database exists.
            for (Path file : StoreContents.read(repaired).files().reversed()) {
                moves.put(file, store.resolveSibling(file.getFileName()));
            }
            moveAll(moves);
        } catch (IOException | RuntimeException e) {
            removeFolder(place);
            Files.delete(aside);
            throw e;
        }
        Files.delete(place);
        return Map.entry(made.check(), Optional.of(aside));
    }

    /** Moves all files, in order; if one move fails, undoes the others. */
    static void moveAll(Map<Path, Path> moves) throws IOException {
        List<Path> done = new ArrayList<>();
        for (Map.Entry<Path, Path> move : moves.entrySet()) {
            try {
                Files.move(move.getKey(), move.getValue());
                done.add(move.getKey());
            } catch (IOException e) {
                for (Path file : done.reversed()) {
                    Files.move(moves.get(file), file);
                }
                throw new IOException(
                        move.getKey()
                                + " could not be moved to "
                                + move.getValue()
                                + ": "
                                + (e instanceof FileAlreadyExistsException
                                        ? "there is a file already"
                                        : Reason.of(e))
                                + " (everything was put back)",
                        e);
            }
        }
    }

    private static void removeFolder(Path folder) throws IOException {
        try (Stream<Path> files = Files.list(folder)) {
            for (Path file : files.toList()) {
                Files.delete(file);
            }
        }
        Files.delete(folder);
    }

    /** Returns the fields for JSON, in order. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("store", store);
        fields.put("whole", isWhole);
        fields.put("frame", frame);
        fields.put("knownFrame", knownFrame);
        if (frame >= 0) {
            fields.put("stateHash", String.format("%016x", stateHash));
        }
        fields.put("problems", problems);
        return fields;
    }

    /**
     * Applies the records of a store, up to the first one that cannot be applied.
     *
     * @return the frame and the reason of the failure; empty if all records were applied
     */
    static Optional<End> make(Replay replay, StoreReading contents) {
        for (JournalRecord record : contents.records()) {
            long before = replay.frame();
            try {
                if (!replay.take(record)) {
                    return Optional.of(
                            new End(
                                    before,
                                    replay.divergence().orElseThrow().message()
                                            + " from what was journalled (damage, or another"
                                            + " processor or version of REVE)"));
                }
            } catch (PhysicsException refused) {
                throw new PhysicsException(
                        refused.status(), contents.name() + ": " + refused.getMessage());
            } catch (CorruptException e) {
                boolean laws = before < 0 && !contents.damagedLibraries().isEmpty();
                return Optional.of(
                        new End(
                                before,
                                e.getMessage()
                                        + (laws
                                                ? "; put the same library into a folder, and name"
                                                        + " that with --laws"
                                                : "")));
            }
        }
        return Optional.empty();
    }

    /**
     * Reads a store that contains something.
     *
     * @throws CorruptException if it is not a store, or is empty
     */
    static StoreReading contents(StoreAddress store) throws IOException {
        return required(store.read());
    }

    private static StoreReading required(StoreReading contents) {
        if (contents.isEmpty()) {
            boolean isThere = contents instanceof StoreContents files && Files.exists(files.file());
            throw new CorruptException(
                    contents.name()
                            + (isThere ? " is an empty store" : " is not there")
                            + ": there is nothing to check");
        }
        return contents;
    }

    private static Made made(StoreReading contents, Optional<Path> folder, LawPath laws) {
        List<String> problems = new ArrayList<>(contents.problems());
        LawFiles found = new LawFiles(laws, problems::add);
        Optional<End> end;
        long frame;
        long hash;
        try (Replay replay = new Replay(Optional.empty(), folder, Pacing.FAST, laws, found::find)) {
            end = make(replay, contents);
            end.ifPresent(early -> problems.add(early.reason()));
            frame = end.map(End::frame).orElse(replay.frame());
            hash = end.isPresent() || frame < 0 ? 0 : hash(replay);
        }
        if (end.isPresent() && frame >= 0) {
            hash = hashAt(contents, folder, laws, found, frame);
        }
        return new Made(
                contents,
                found,
                new StoreCheck(
                        contents.name(),
                        contents.isWhole() && end.isEmpty(),
                        frame,
                        Math.max(frame, contents.knownFrame()),
                        hash,
                        List.copyOf(problems)));
    }

    private static long hashAt(
            StoreReading contents,
            Optional<Path> folder,
            LawPath laws,
            LawFiles found,
            long frame) {
        try (Replay replay = new Replay(Optional.empty(), folder, Pacing.FAST, laws, found::find)) {
            for (JournalRecord record : contents.records()) {
                if (!replay.take(record, frame) && replay.frame() == frame) {
                    break;
                }
            }
            return hash(replay);
        }
    }

    private static long hash(Replay replay) {
        try (Simulation made = replay.release()) {
            return made.physics().stateHash();
        }
    }

    private static void write(Made made, Path repaired) throws IOException {
        List<JournalRecord.Library> libraries = new ArrayList<>();
        JournalRecord.@Nullable Image image = null;
        for (JournalRecord record : made.contents().records()) {
            switch (record) {
                case JournalRecord.Library library -> libraries.add(library);
                case JournalRecord.Image first -> image = first;
                case JournalRecord.Frame frame -> {}
            }
        }
        libraries.addAll(made.laws().given());
        try (SqliteStore store =
                new SqliteStore(StoreContents.read(repaired), SqliteStore.Durability.FULL)) {
            JournalSink.Place place = store.place();
            place.write(libraries, Objects.requireNonNull(image));
            for (JournalRecord record : made.contents().records()) {
                if (record instanceof JournalRecord.Frame frame
                        && frame.frame() <= made.check().frame()) {
                    store.write(record);
                }
            }
            store.sync();
        }
    }
}
