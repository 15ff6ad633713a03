// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import reve.core.image.CorruptException;
import reve.core.image.Trees;
import reve.pe.PreparedLibrary;
import reve.pe.adapter.LawChange;
import reve.pe.adapter.LawLibrary;
import reve.pe.adapter.LawList;
import reve.pe.adapter.Quarantined;
import reve.worlds.journal.FrameCodec;
import reve.worlds.journal.ImageCodec;
import reve.worlds.journal.JournalRecord;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.StoreReading;

import java.io.IOException;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;

/**
 * The laws of a store at the frame from which a world would resume. They are read without being
 * opened, so a law that crashes does no harm. For one thread. No other process may have a store in
 * files open.
 *
 * @param store the store
 * @param isWhole true if no data is lost and the bytes of all laws are available
 * @param frame from which a world can resume; -1 for none
 * @param laws the loaded libraries, in the order of loading
 * @param quarantined the libraries that failed and stay unloaded
 * @param problems damaged or missing parts, one line each
 */
public record StoreLaws(
        String store,
        boolean isWhole,
        long frame,
        List<Law> laws,
        List<Quarantined> quarantined,
        List<String> problems) {

    /**
     * A loaded library.
     *
     * @param library the library; it has no bytes if those in the store are damaged or missing and
     *     no folder contains them
     * @param kind {@code native}, {@code text}, {@code python} or {@code missing}
     */
    public record Law(LawLibrary library, String kind) {
        Map<String, Object> fields() {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("library", library.name());
            fields.put("sha256", library.sha256());
            fields.put("kind", kind);
            fields.put("bytes", library.bytes().length);
            fields.put("parameters", library.parameters());
            return fields;
        }
    }

    /**
     * Reads the laws of a store without changing it.
     *
     * @param laws search path for replacements of damaged laws
     * @throws CorruptException if it is not a store, or contains nothing that can be read
     * @throws IOException if it cannot be read, or another process has it open
     */
    public static StoreLaws of(StoreAddress store, LawPath laws) throws IOException {
        StoreReading contents = StoreCheck.contents(store);
        List<String> problems = new ArrayList<>(contents.problems());
        LawFiles found = new LawFiles(laws, problems::add);
        Map<String, byte[]> libraries = new HashMap<>();
        LawList list = new LawList();
        long frame = -1;
        boolean isRead = true;
        for (JournalRecord record : contents.records()) {
            try {
                switch (record) {
                    case JournalRecord.Library library ->
                            libraries.put(LawFiles.sha256(library.bytes()), library.bytes());
                    case JournalRecord.Image image -> {
                        ImageCodec.Stored stored = ImageCodec.open(image.bytes());
                        list.restore(
                                ImageCodec.libraries(stored, each -> bytes(each, libraries, found)),
                                ImageCodec.quarantined(stored));
                        frame = image.frame();
                    }
                    case JournalRecord.Frame made -> {
                        for (LawChange change :
                                FrameCodec.laws(
                                        Trees.read(made.json()),
                                        each -> bytes(each, libraries, found))) {
                            list.apply(change);
                        }
                        frame = made.frame();
                    }
                }
            } catch (CorruptException | IllegalArgumentException damaged) {
                isRead = false;
                problems.add(store + ": after frame " + frame + ": " + damaged.getMessage());
                break;
            }
        }
        List<Law> present =
                list.libraries().stream().map(each -> new Law(each, kind(each))).toList();
        for (Law law : present) {
            if (law.kind().equals("missing")) {
                problems.add(
                        store
                                + ": the law library "
                                + law.library().name()
                                + " (SHA-256 "
                                + law.library().sha256()
                                + ") is damaged or missing; put the same library into a folder, and"
                                + " name that with --laws");
            }
        }
        return new StoreLaws(
                contents.name(),
                contents.isWhole()
                        && isRead
                        && present.stream().noneMatch(law -> law.kind().equals("missing")),
                frame,
                present,
                list.quarantined(),
                List.copyOf(problems));
    }

    /**
     * Returns the bytes of a library; an empty array if neither the store nor a folder contains
     * them.
     */
    private static byte[] bytes(String sha256, Map<String, byte[]> libraries, LawFiles found) {
        byte[] bytes = libraries.get(sha256);
        return Optional.ofNullable(bytes == null ? found.find(sha256) : bytes).orElse(new byte[0]);
    }

    private static String kind(LawLibrary library) {
        if (library.bytes().length == 0) {
            return "missing";
        }
        return PreparedLibrary.isPython(library.bytes())
                ? "python"
                : library.isText() ? "text" : "native";
    }

    /** Returns the fields for JSON, in order. */
    public Map<String, Object> fields() {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("store", store);
        fields.put("whole", isWhole);
        fields.put("frame", frame);
        fields.put("laws", laws.stream().map(Law::fields).toList());
        fields.put("quarantined", quarantined.stream().map(StoreLaws::fields).toList());
        fields.put("problems", problems);
        return fields;
    }

    private static Map<String, Object> fields(Quarantined law) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("library", law.library());
        fields.put("sha256", law.sha256());
        fields.put("frame", law.frame());
        fields.put("status", law.status().name());
        fields.put("message", law.message());
        return fields;
    }
}
