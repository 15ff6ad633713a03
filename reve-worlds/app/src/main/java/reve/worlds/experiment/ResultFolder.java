// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import reve.core.disk.Reason;
import reve.core.disk.WholeFile;
import reve.core.file.Experiment;
import reve.core.plugin.Plugins;
import reve.pe.posix.RegularFile;
import reve.worlds.Product;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.OutputStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.LinkOption;
import java.nio.file.Path;
import java.security.DigestInputStream;
import java.security.MessageDigest;
import java.security.NoSuchAlgorithmException;
import java.util.ArrayList;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Optional;
import java.util.TreeMap;
import java.util.regex.Pattern;
import java.util.stream.Stream;

/**
 * A folder with the results of an experiment. It contains {@value #RUNS} (a row for each run),
 * {@value #SERIES} (all measurements), {@value #RESULT} (hashes and versions), plots, and {@value
 * #REPORT} (a page with the tables and plots).
 */
public final class ResultFolder {
    /** The table of runs. */
    public static final String RUNS = "runs.csv";

    /** The table of all measurements. */
    public static final String SERIES = "series.csv";

    /** The page with tables and plots. */
    public static final String REPORT = "report.html";

    /**
     * The file with hashes and versions. A folder that contains this file is a folder of results.
     */
    public static final String RESULT = "result.json";

    /** Folder for results that differ from earlier ones. */
    public static final String CHANGED = "changed";

    /** Folder for the output of agents' programs. */
    public static final String AGENTS = "agents";

    private static final int FORMAT = 1;
    private static final int MAX_BYTES = 1 << 30;

    /**
     * Fields of a run that must be equal in each repetition of the run, for every version of this
     * program.
     */
    private static final List<String> COMPARED =
            List.of("run", "seed", "frames", "state", "values", "stateHash");

    /** Maximum number of characters of a field in a message. */
    private static final int SHOWN = 100;

    /** Names of incomplete files. */
    private static final Pattern PART =
            Pattern.compile(
                    "("
                            + Pattern.quote(RUNS)
                            + "|"
                            + Pattern.quote(SERIES)
                            + "|"
                            + Pattern.quote(RESULT)
                            + "|"
                            + Pattern.quote(REPORT)
                            + "|.+-over-.+\\.png)\\.part\\d*");

    private static final JsonMapper MAPPER = JsonMapper.shared();

    private final Path folder;

    /** Creates an object for a folder. The folder need not exist. */
    public ResultFolder(Path folder) {
        this.folder = folder;
    }

    /** Returns whether the folder contains results. */
    public boolean hasResults() {
        return Files.exists(folder.resolve(RESULT));
    }

    /**
     * Refuses a folder that contains files other than results of this experiment.
     *
     * @throws IOException with the reason
     */
    public void requireFor(Experiment experiment) throws IOException {
        if (hasResults()) {
            String other = meta().path("experiment").asString("");
            if (!other.equals(experiment.name())) {
                throw new IOException(
                        folder
                                + " contains the results of the experiment "
                                + other
                                + ", expected "
                                + experiment.name()
                                + "; name another folder with --out");
            }
        } else if (Files.isDirectory(folder) && !Files.exists(folder.resolve(RunJournal.NAME))) {
            try (Stream<Path> files = Files.list(folder)) {
                if (files.anyMatch(file -> !file.endsWith(AGENTS))) {
                    throw new IOException(
                            folder
                                    + " contains files and no results of an experiment; remove"
                                    + " the folder, or name another one with --out");
                }
            }
        }
    }

    private JsonNode meta() throws IOException {
        try {
            JsonNode meta = MAPPER.readTree(text(RESULT));
            if (meta.path("format").asInt(0) != FORMAT) {
                throw new IOException(
                        folder.resolve(RESULT) + " has another format, expected " + FORMAT);
            }
            return meta;
        } catch (JacksonException damaged) {
            throw new IOException(folder.resolve(RESULT) + " is not JSON", damaged);
        }
    }

    private String text(String name) throws IOException {
        Path file = folder.resolve(name);
        try {
            return new String(RegularFile.read(file, MAX_BYTES), StandardCharsets.UTF_8);
        } catch (IOException unreadable) {
            throw Reason.naming(file, unreadable);
        }
    }

    /**
     * A comparison with earlier results.
     *
     * @param difference the first difference; empty if the results are identical
     * @param since the changes of versions, files and laws since the earlier results
     */
    public record Comparison(Optional<Difference> difference, List<String> since) {}

    /** Compares new results with those in the folder, bit by bit. */
    public Comparison compare(Experiment experiment, List<RunResult> results) throws IOException {
        List<List<String>> runs = table(RUNS);
        List<List<String>> series = table(SERIES);
        JsonNode meta = meta();
        return new Comparison(
                Difference.first(runs, series, new ResultTable(experiment, results), results)
                        .or(() -> inRuns(meta.path("runs"), experiment, results)),
                since(meta, experiment, results));
    }

    /** Compares the runs in {@value #RESULT} with new ones. */
    private static Optional<Difference> inRuns(
            JsonNode before, Experiment experiment, List<RunResult> results) {
        for (int i = 0; i < results.size(); i++) {
            // The new results are written as JSON and read back, so that their numbers have the
            // same form as the numbers in the file.
            JsonNode now =
                    MAPPER.readTree(
                            MAPPER.writeValueAsString(runFields(experiment, results.get(i))));
            for (String field : COMPARED) {
                JsonNode was = before.path(i).path(field);
                if (!was.equals(now.path(field))) {
                    return Optional.of(
                            new Difference(
                                    "run " + (i + 1) + " in " + RESULT,
                                    Optional.empty(),
                                    field,
                                    shown(was),
                                    shown(now.path(field))));
                }
            }
        }
        return Optional.empty();
    }

    private static String shown(JsonNode value) {
        String text = value.isMissingNode() ? "" : value.toString();
        return text.length() <= SHOWN ? text : text.substring(0, SHOWN) + "…";
    }

    private List<List<String>> table(String name) throws IOException {
        return ResultTable.parse(text(name))
                .filter(rows -> !rows.isEmpty())
                .orElseThrow(
                        () ->
                                new IOException(
                                        folder.resolve(name) + " is damaged: it is no table"));
    }

    private static List<String> since(JsonNode meta, Experiment experiment, List<RunResult> results)
            throws IOException {
        List<String> since = new ArrayList<>();
        String version = meta.path("version").asString("");
        if (!version.equals(Product.version())) {
            since.add("made by version " + version + ", this is version " + Product.version());
        }
        String machine = meta.path("machine").asString("");
        if (!machine.equals(machine())) {
            since.add("made on " + machine + ", this is " + machine());
        }
        changed("file", meta.path("files"), files(experiment), since);
        changed("law", meta.path("laws"), laws(results), since);
        changed("plugin", meta.path("plugins"), plugins(), since);
        return since;
    }

    private static void changed(
            String what, JsonNode before, Map<String, String> now, List<String> since) {
        Map<String, String> all = new TreeMap<>(now);
        before.propertyNames().forEach(name -> all.putIfAbsent(name, ""));
        for (String name : all.keySet()) {
            String old = before.path(name).asString("");
            if (!old.equals(all.get(name))) {
                since.add(
                        "the "
                                + what
                                + " "
                                + name
                                + (old.isEmpty()
                                        ? " is new"
                                        : all.get(name).isEmpty()
                                                ? " is not used any more"
                                                : " has changed"));
            }
        }
    }

    /**
     * Writes results and plots. Replaces earlier ones. {@value #RESULT} is removed first and
     * written last, so that the folder counts as a folder of results only while it is complete.
     *
     * @return the names of the plots
     */
    public List<String> write(Experiment experiment, List<RunResult> results) throws IOException {
        Files.createDirectories(folder);
        Files.deleteIfExists(folder.resolve(RESULT));
        removeParts();
        var table = new ResultTable(experiment, results);
        write(RUNS, table.runs());
        write(SERIES, table.series());
        List<String> plots = Plots.write(folder, experiment, results);
        String page = Report.of(experiment, results, files(experiment), laws(results));
        WholeFile.write(
                folder.resolve(REPORT), out -> out.write(page.getBytes(StandardCharsets.UTF_8)));
        String text =
                MAPPER.writerWithDefaultPrettyPrinter()
                                .writeValueAsString(fields(experiment, results))
                        + "\n";
        WholeFile.write(
                folder.resolve(RESULT), out -> out.write(text.getBytes(StandardCharsets.UTF_8)));
        return plots;
    }

    /** Removes incomplete files that a killed process has left. */
    private void removeParts() throws IOException {
        List<Path> parts;
        try (Stream<Path> files = Files.list(folder)) {
            parts = files.filter(file -> PART.matcher(file.getFileName() + "").matches()).toList();
        }
        for (Path part : parts) {
            if (Files.isRegularFile(part, LinkOption.NOFOLLOW_LINKS)) {
                Files.delete(part);
            }
        }
    }

    private void write(String name, List<List<String>> rows) throws IOException {
        WholeFile.write(
                folder.resolve(name),
                out -> {
                    for (List<String> row : rows) {
                        String line = ResultTable.line(row) + "\n";
                        out.write(line.getBytes(StandardCharsets.UTF_8));
                    }
                });
    }

    /** Returns the fields of the result file. */
    public static Map<String, Object> fields(Experiment experiment, List<RunResult> results)
            throws IOException {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("format", FORMAT);
        fields.put("experiment", experiment.name());
        fields.put("version", Product.version());
        fields.put("machine", machine());
        fields.put("files", files(experiment));
        fields.put("laws", laws(results));
        fields.put("plugins", plugins());
        fields.put("units", units(experiment));
        fields.put("runs", results.stream().map(run -> runFields(experiment, run)).toList());
        return fields;
    }

    /** Returns the SI units of the variables and measures in the table of runs, as far as known. */
    private static Map<String, String> units(Experiment experiment) {
        Map<String, String> units = new LinkedHashMap<>();
        for (String name : experiment.variables()) {
            experiment.variableUnit(name).ifPresent(unit -> units.put(name, unit.symbol()));
        }
        for (int i = 0; i < experiment.measures().size(); i++) {
            String name = experiment.measures().get(i);
            experiment.valueUnit(i).ifPresent(unit -> units.put(name, unit.si().symbol()));
        }
        return units;
    }

    /** Returns the fields of a run in the result file. */
    public static Map<String, Object> runFields(Experiment experiment, RunResult run) {
        Map<String, Object> fields = new LinkedHashMap<>();
        fields.put("run", run.point().number());
        run.point().itsCase().ifPresent(name -> fields.put("case", name));
        fields.put("seed", run.point().seed());
        fields.put("frames", run.frames());
        fields.put("sweep", run.point().values());
        fields.put("state", run.state().name().toLowerCase(Locale.ROOT));
        if (!run.message().isEmpty()) {
            fields.put("message", run.message());
        }
        if (!run.notes().isEmpty()) {
            fields.put("notes", run.notes());
        }
        Map<String, Object> values = new LinkedHashMap<>();
        Map<String, Object> expected = new LinkedHashMap<>();
        for (int i = 0; i < experiment.measures().size(); i++) {
            String measure = experiment.measures().get(i);
            run.values().get(i).ifPresent(value -> values.put(measure, value));
            run.expected().get(i).ifPresent(value -> expected.put(measure, value));
        }
        fields.put("values", values);
        if (!expected.isEmpty()) {
            fields.put("expected", expected);
        }
        fields.put("stateHash", run.stateHash());
        return fields;
    }

    static String machine() {
        return System.getProperty("os.name") + " " + System.getProperty("os.arch");
    }

    private static Map<String, String> laws(List<RunResult> results) {
        Map<String, String> laws = new TreeMap<>();
        results.forEach(run -> laws.putAll(run.laws()));
        return laws;
    }

    /** Returns the hashes of the plugins by the names of their files. */
    static Map<String, String> plugins() {
        Map<String, String> hashes = new TreeMap<>();
        Plugins.current().infos().forEach(plugin -> hashes.put(plugin.file(), plugin.sha256()));
        return hashes;
    }

    private static Map<String, String> files(Experiment experiment) throws IOException {
        Map<String, String> hashes = new TreeMap<>();
        for (Map.Entry<String, Path> file : experiment.inputs().entrySet()) {
            hashes.put(file.getKey(), sha256(file.getValue()));
        }
        return hashes;
    }

    static String sha256(Path file) throws IOException {
        try (var in =
                new DigestInputStream(
                        Files.newInputStream(file), MessageDigest.getInstance("SHA-256"))) {
            in.transferTo(OutputStream.nullOutputStream());
            return HexFormat.of().formatHex(in.getMessageDigest().digest());
        } catch (NoSuchAlgorithmException e) {
            throw new AssertionError("every Java platform has SHA-256", e);
        }
    }
}
