// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.disk.Reason;
import reve.core.file.Experiment;
import reve.core.file.LawReference;
import reve.core.file.LawStep;
import reve.core.file.RunPlan;
import reve.pe.PhysicsException;
import reve.pe.posix.RegularFile;
import reve.worlds.Product;
import reve.worlds.server.LawPath;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.FileChannel;
import java.nio.channels.OverlappingFileLockException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.nio.file.StandardOpenOption;
import java.util.ArrayList;
import java.util.Collections;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;
import java.util.SortedMap;
import java.util.TreeMap;
import java.util.zip.CRC32;

/**
 * The journal of an unfinished experiment: the file {@value #NAME} in the folder of its results. It
 * contains the result of each finished run. If the process is killed, a later process reads these
 * results and runs only the other runs.
 *
 * <p>The journal also contains the hashes of the files, laws and engine on which the runs depend.
 * Results are used again only if none of these has changed. A failed run is not kept, because the
 * machine may have caused the failure. The file is locked as long as this object is open. For any
 * thread.
 */
public final class RunJournal implements AutoCloseable {
    /** File name of the journal. */
    public static final String NAME = "unfinished.jsonl";

    private static final int FORMAT = 1;
    private static final int MAX_BYTES = 1 << 30;
    private static final int SUM_CHARACTERS = 8;
    private static final String FILE = "file";
    private static final String LAW = "law";
    private static final String ENGINE = "engine";
    private static final String ENGINE_FILE = "libvesper.so";
    private static final String SHA256 = "sha256";

    private static final JsonMapper MAPPER = JsonMapper.shared();

    private final Path file;
    private final FileChannel channel;
    private final Experiment experiment;
    private final LawPath laws;
    private final SortedMap<Integer, RunResult> earlier = new TreeMap<>();

    /** The hashes in the journal, by their kind (file, law, engine) and the name. */
    private final Map<String, Map<String, String>> known =
            Map.of(
                    FILE,
                    new LinkedHashMap<>(),
                    LAW,
                    new LinkedHashMap<>(),
                    ENGINE,
                    new LinkedHashMap<>());

    private Optional<String> dropped = Optional.empty();
    private int kept;
    private boolean complete;

    private RunJournal(Path file, FileChannel channel, Experiment experiment, LawPath laws) {
        this.file = file;
        this.channel = channel;
        this.experiment = experiment;
        this.laws = laws.forWorld(experiment.worldFolder());
    }

    /**
     * Opens the journal in a folder. Creates it if there is none.
     *
     * @param laws search path of laws
     * @throws IOException naming the file and the reason, for example if another process has opened
     *     the journal, or if it belongs to another experiment
     */
    public static RunJournal open(Path folder, Experiment experiment, LawPath laws)
            throws IOException {
        Path file = folder.resolve(NAME);
        try {
            FileChannel channel = locked(file);
            var journal = new RunJournal(file, channel, experiment, laws);
            try {
                journal.begin();
                return journal;
            } catch (IOException | RuntimeException failure) {
                channel.close();
                throw failure;
            }
        } catch (IOException failure) {
            throw Reason.naming(file, failure);
        }
    }

    private static FileChannel locked(Path file) throws IOException {
        while (true) {
            if (Files.exists(file, LinkOption.NOFOLLOW_LINKS)) {
                String other = RegularFile.otherKind(file);
                if (!other.isEmpty()) {
                    throw new IOException("expected a regular file, found " + other);
                }
            }
            FileChannel channel =
                    FileChannel.open(
                            file,
                            Set.of(
                                    StandardOpenOption.CREATE,
                                    StandardOpenOption.READ,
                                    StandardOpenOption.WRITE,
                                    LinkOption.NOFOLLOW_LINKS));
            if (!lock(channel)) {
                channel.close();
                throw new IOException(
                        "another command writes results into this folder; wait until it ends, or"
                                + " name another folder with --out");
            }
            if (Files.exists(file, LinkOption.NOFOLLOW_LINKS)) {
                return channel;
            }
            channel.close(); // the process that held the lock has removed the file
        }
    }

    /** Locks the file until the channel is closed. Returns false if it is locked already. */
    private static boolean lock(FileChannel channel) throws IOException {
        try {
            return channel.tryLock() != null;
        } catch (OverlappingFileLockException sameProcess) {
            return false;
        }
    }

    /** Reads the results of an earlier process. Starts an empty journal if they cannot be used. */
    private void begin() throws IOException {
        List<JsonNode> entries = new ArrayList<>();
        long end = readEntries(entries);
        if (!entries.isEmpty()) {
            JsonNode header = entries.getFirst();
            String other = header.path("experiment").asString("");
            if (!other.equals(experiment.name())) {
                throw new IOException(
                        "it contains runs of the experiment "
                                + other
                                + ", expected "
                                + experiment.name()
                                + "; name another folder with --out");
            }
            boolean hasRuns = entries.stream().anyMatch(entry -> entry.has(RunRecord.RUN));
            Optional<String> changed = changed(header, entries);
            dropped = changed.isEmpty() ? take(entries) : changed.filter(_ -> hasRuns);
        }
        if (earlier.isEmpty()) {
            known.values().forEach(Map::clear);
            channel.truncate(0);
            channel.position(0);
            append(header());
        } else {
            channel.truncate(end);
            channel.position(end);
        }
        kept = earlier.size();
        if (!known.get(ENGINE).containsKey(ENGINE_FILE)) {
            record(ENGINE, ENGINE_FILE);
        }
        recordFiles();
    }

    /** Uses the results in the journal. Returns the reason if they are not valid. */
    private Optional<String> take(List<JsonNode> entries) {
        try {
            for (JsonNode entry : entries) {
                if (entry.has(RunRecord.RUN)) {
                    int index =
                            Objects.checkIndex(
                                    entry.path(RunRecord.RUN).asInt() - 1, experiment.runs());
                    earlier.put(index, RunRecord.read(entry, experiment.point(index)));
                }
            }
        } catch (RuntimeException invalid) {
            earlier.clear();
            return Optional.of(file + " is damaged");
        }
        known.get(FILE).keySet().forEach(experiment::addInput);
        return Optional.empty();
    }

    /**
     * Reads the entries up to the first one that is incomplete, as after a crash.
     *
     * @return the length of the entries in the file [bytes]
     */
    private int readEntries(List<JsonNode> entries) throws IOException {
        if (channel.size() > MAX_BYTES) {
            throw new IOException("it has more than " + MAX_BYTES + " bytes; remove it");
        }
        byte[] bytes = new byte[(int) channel.size()];
        ByteBuffer buffer = ByteBuffer.wrap(bytes);
        while (buffer.hasRemaining() && channel.read(buffer) >= 0) {
            // The loop body is empty. A call of read() may return fewer bytes than requested, so it
            // is repeated until all bytes are read.
        }
        int begin = 0;
        for (int i = 0; i < buffer.position(); i++) {
            if (bytes[i] == '\n') {
                Optional<JsonNode> entry = entry(bytes, begin, i);
                if (entry.isEmpty()) {
                    break;
                }
                entries.add(entry.get());
                begin = i + 1;
            }
        }
        return begin;
    }

    private static Optional<JsonNode> entry(byte[] bytes, int begin, int end) {
        int content = begin + SUM_CHARACTERS + 1;
        if (content >= end) {
            return Optional.empty();
        }
        String sum = new String(bytes, begin, SUM_CHARACTERS, StandardCharsets.UTF_8);
        if (!sum.equals(sum(bytes, content, end - content))) {
            return Optional.empty();
        }
        try {
            return Optional.of(
                    MAPPER.readTree(
                            new String(bytes, content, end - content, StandardCharsets.UTF_8)));
        } catch (JacksonException noJson) {
            return Optional.empty();
        }
    }

    private static String sum(byte[] bytes, int begin, int count) {
        CRC32 sum = new CRC32();
        sum.update(bytes, begin, count);
        return HexFormat.of().toHexDigits((int) sum.getValue());
    }

    private Map<String, Object> header() {
        Map<String, Object> header = new LinkedHashMap<>();
        header.put("format", FORMAT);
        header.put("experiment", experiment.name());
        header.put("version", Product.version());
        header.put("machine", ResultFolder.machine());
        header.put("plugins", ResultFolder.plugins().toString());
        return header;
    }

    /**
     * Returns a message about the first change since the runs in the journal, for example of the
     * version, a file or a law; empty if nothing has changed. Puts the hashes in the journal into
     * {@link #known}.
     */
    private Optional<String> changed(JsonNode header, List<JsonNode> entries) throws IOException {
        JsonNode own = MAPPER.readTree(MAPPER.writeValueAsString(header()));
        for (String key : own.propertyNames()) {
            if (!own.path(key).equals(header.path(key))) {
                return Optional.of(
                        "they were made by "
                                + key
                                + " "
                                + header.path(key).asString("?")
                                + ", this is "
                                + own.path(key).asString());
            }
        }
        for (JsonNode entry : entries) {
            for (String kind : known.keySet()) {
                if (entry.has(kind)) {
                    String name = entry.path(kind).asString("");
                    String now = hash(kind, name);
                    if (!now.equals(entry.path(SHA256).asString(""))) {
                        return Optional.of(
                                "the "
                                        + kind
                                        + " "
                                        + name
                                        + (now.isEmpty() ? " is missing" : " has changed"));
                    }
                    known.get(kind).put(name, now);
                }
            }
        }
        return Optional.empty();
    }

    /** Returns the SHA-256 of a file, a law or the engine; an empty text if there is none. */
    private String hash(String kind, String name) throws IOException {
        Optional<Path> place;
        try {
            place =
                    switch (kind) {
                        case FILE -> experiment.findInput(name);
                        case LAW -> Optional.of(laws.find(name).file());
                        default ->
                                Optional.of(Product.nativeFolder().resolve(ENGINE_FILE))
                                        .filter(Files::exists);
                    };
        } catch (PhysicsException none) {
            return "";
        }
        return place.isEmpty() ? "" : ResultFolder.sha256(place.get());
    }

    /** Returns the results of an earlier process by the index of the run, from 0. */
    public SortedMap<Integer, RunResult> earlier() {
        return Collections.unmodifiableSortedMap(earlier);
    }

    /**
     * Returns the reason why results of an earlier process are not used; empty if there are none.
     */
    public Optional<String> dropped() {
        return dropped;
    }

    /** Returns the number of results in the journal. */
    public synchronized int kept() {
        return kept;
    }

    /**
     * Records the hashes of the files and laws that a run uses. Called before the run.
     *
     * @throws IOException naming the file that cannot be read or written
     */
    synchronized void uses(RunPlan plan) throws IOException {
        recordFiles();
        for (LawReference law : plan.world().laws()) {
            recordLaw(law);
        }
        for (LawStep step : plan.steps()) {
            if (step.change() == LawStep.Change.LOAD) {
                recordLaw(step.law());
            }
        }
    }

    private void recordFiles() throws IOException {
        for (String name : experiment.inputs().keySet()) {
            if (!known.get(FILE).containsKey(name)) {
                record(FILE, name);
            }
        }
    }

    private void recordLaw(LawReference law) throws IOException {
        if (law.text().isEmpty() && !known.get(LAW).containsKey(law.name())) {
            record(LAW, law.name());
        }
    }

    private void record(String kind, String name) throws IOException {
        String hash = hash(kind, name);
        Map<String, Object> entry = new LinkedHashMap<>();
        entry.put(kind, name);
        entry.put(SHA256, hash);
        append(entry);
        known.get(kind).put(name, hash);
    }

    /**
     * Adds the result of a run. Ignores a failed run.
     *
     * @throws IOException naming the file and the reason
     */
    synchronized void add(RunResult result) throws IOException {
        if (result.state() == RunResult.State.FAILED) {
            return;
        }
        append(RunRecord.fields(result));
        kept++;
    }

    private void append(Map<String, Object> entry) throws IOException {
        byte[] content = MAPPER.writeValueAsBytes(entry);
        ByteBuffer line = ByteBuffer.allocate(SUM_CHARACTERS + 1 + content.length + 1);
        line.put(sum(content, 0, content.length).getBytes(StandardCharsets.US_ASCII))
                .put((byte) ' ')
                .put(content)
                .put((byte) '\n')
                .flip();
        try {
            while (line.hasRemaining()) {
                channel.write(line);
            }
        } catch (IOException failure) {
            throw Reason.naming(file, failure);
        }
    }

    /** Removes the journal, because the results of all runs are in other files. */
    public synchronized void complete() throws IOException {
        complete = true;
        Files.deleteIfExists(file);
    }

    /** Closes the journal. Removes it if it contains no result. */
    @Override
    public synchronized void close() throws IOException {
        if (!complete && kept == 0) {
            complete();
        }
        channel.close();
    }
}
