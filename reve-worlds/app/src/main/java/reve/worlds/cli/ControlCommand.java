// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import org.jspecify.annotations.Nullable;

import picocli.CommandLine.Command;
import picocli.CommandLine.Mixin;
import picocli.CommandLine.Model.CommandSpec;
import picocli.CommandLine.Option;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.Parameters;
import picocli.CommandLine.Spec;

import reve.agent.ActResult;
import reve.agent.AgentClient;
import reve.agent.AgentException;
import reve.agent.Perception;
import reve.core.text.Suggestion;

import java.io.IOException;
import java.io.PrintWriter;
import java.nio.charset.MalformedInputException;
import java.nio.file.Files;
import java.nio.file.NoSuchFileException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.concurrent.Callable;

/** The command {@code control}: sends one request of the role control to a running server. */
@Command(
        name = "control",
        description =
                "Sends a command to a running world: pause, step, run, speed, snapshot, rewind, "
                        + "save, fork, edit, add, change, remove, rule, batch, load-law, set-law, set-budget, "
                        + "unload-law, release, profile, cluster, move-world, drain-node, "
                        + "add-world, changes, near, region, picture, shut-down; or asks: state, laws, inspect, search, "
                        + "perceived, ledger, audit. For example: "
                        + "control rewind image=calm, "
                        + "control add item.yaml, "
                        + "control change item=blue physics.velocity=0,3,0, "
                        + "control load-law file=wind.law.")
public final class ControlCommand implements Callable<Integer> {
    private static final int MAX_TEXT_BYTES = 65_536;

    /** Fields that each command accepts as FIELD=VALUE, by command. */
    private static final Map<String, Set<String>> COMMANDS =
            new TreeMap<>(
                    Map.ofEntries(
                            Map.entry("pause", Set.of()),
                            Map.entry("step", Set.of("frames")),
                            Map.entry("run", Set.of()),
                            Map.entry("snapshot", Set.of("image")),
                            Map.entry("rewind", Set.of("image")),
                            Map.entry("save", Set.of("file")),
                            Map.entry("fork", Set.of("frames")),
                            Map.entry("edit", Set.of("item", "property", "value")),
                            Map.entry("add", Set.of()),
                            Map.entry("change", Set.of("item")),
                            Map.entry("remove", Set.of("item", "cascade")),
                            Map.entry("rule", Set.of("name", "rule")),
                            Map.entry("batch", Set.of()),
                            Map.entry("profile", Set.of()),
                            Map.entry("cluster", Set.of()),
                            Map.entry("move-world", Set.of("world", "node")),
                            Map.entry("drain-node", Set.of("node", "drained")),
                            Map.entry("add-world", Set.of("file", "text", "asleep")),
                            Map.entry("changes", Set.of()),
                            Map.entry("near", Set.of("location", "distance", "most")),
                            Map.entry("region", Set.of("from", "to")),
                            Map.entry("release", Set.of("library")),
                            Map.entry("speed", Set.of("factor")),
                            Map.entry("load-law", Set.of("library", "file", "text", "swap")),
                            Map.entry("set-law", Set.of("library", "swap")),
                            Map.entry(
                                    "set-budget",
                                    Set.of("library", "milliseconds", "frames", "then", "every")),
                            Map.entry("unload-law", Set.of("library")),
                            Map.entry("picture", Set.of()),
                            Map.entry("shut-down", Set.of())));

    private static final String PARAMETERS = "parameters.";
    private static final Set<String> WITH_PARAMETERS = Set.of("load-law", "set-law");

    /** Questions about the world. The server answers each of them with a report. */
    private static final Map<String, Set<String>> QUESTIONS =
            new TreeMap<>(
                    Map.of(
                            "state", Set.of("roundTrips"),
                            "inspect", Set.of("item"),
                            "perceived", Set.of("client"),
                            "search", Set.of("text"),
                            "laws", Set.of(),
                            "ledger", Set.of("open"),
                            "audit", Set.of("client", "frequent", "most")));

    /** Commands that a paused world executes before its next frame. */
    private static final Set<String> OF_FRAMES =
            Set.of(
                    "edit",
                    "add",
                    "change",
                    "remove",
                    "rule",
                    "batch",
                    "load-law",
                    "set-law",
                    "set-budget",
                    "unload-law",
                    "release",
                    "picture");

    /** Fields whose values are texts, also if they look like numbers. */
    private static final Set<String> TEXTS =
            Set.of(
                    "client",
                    "file",
                    "image",
                    "item",
                    "library",
                    "name",
                    "node",
                    "property",
                    "rule",
                    "text",
                    "then",
                    "world");

    /** Commands whose fields are read from a file. */
    private static final Set<String> FROM_FILES = Set.of("add", "change", "batch", "fork");

    @Spec private CommandSpec spec = CommandSpec.create();

    @Parameters(
            index = "0",
            paramLabel = "COMMAND",
            description = "Name of the command, see agents/protocol/PROTOCOL.md.")
    private String command = "";

    @Parameters(
            index = "1..*",
            paramLabel = "FIELD=VALUE",
            description =
                    "Fields of the command: a number, numbers separated by commas, "
                            + "true, false, null or text. Names and texts to search are "
                            + "always text. add, change, batch and fork also take a "
                            + "FILE of YAML or JSON.")
    private List<String> given = new ArrayList<>();

    @Mixin private ControlTarget target = new ControlTarget();

    @Option(names = "--json", description = "Print the result as one JSON document.")
    private boolean json;

    @Override
    public Integer call() throws IOException {
        Map<String, Object> fields = fields();
        try (AgentClient client = target.connect()) {
            if (QUESTIONS.containsKey(command)) {
                Json.print(spec, client.report(command, fields).content());
                return ExitCode.OK;
            }
            if (command.equals("fork")) {
                tell(foreseen(client, fields));
                return ExitCode.OK;
            }
            boolean waits = OF_FRAMES.contains(command) && isPaused(client);
            if (waits) {
                LinePrinter.message(
                        spec.commandLine().getErr(),
                        List.of(
                                "reve: the world is paused, so "
                                        + command
                                        + " waits for its next frame: `./reve control step` makes"
                                        + " one, `./reve control run` ends the pause"));
                spec.commandLine().getErr().flush();
            }
            ActResult result =
                    waits ? answerWhilePaused(client, fields) : client.command(command, fields);
            tell(result);
            return result.accepted() ? ExitCode.OK : ExitCode.FAILURE;
        } catch (AgentException refused) {
            throw target.refused(refused);
        }
    }

    @SuppressWarnings("unchecked") // the server refuses changes that are no messages
    private Perception foreseen(AgentClient client, Map<String, Object> fields) {
        if (!(fields.get("frames") instanceof Double frames)
                || frames.intValue() != frames
                || frames < 0) {
            throw wrong(
                    "frames is "
                            + fields.getOrDefault("frames", "missing")
                            + ", expected a number of frames, e.g. fork frames=60");
        }
        Object changes = fields.getOrDefault("changes", List.of());
        if (!(changes instanceof List<?> list)
                || !list.stream().allMatch(each -> each instanceof Map<?, ?>)) {
            throw wrong("the changes of fork are " + changes + ", expected a list as for batch");
        }
        return client.foresee(frames.intValue(), (List<Map<String, Object>>) list);
    }

    private ActResult answerWhilePaused(AgentClient client, Map<String, Object> fields)
            throws IOException {
        try {
            return client.command(command, fields);
        } catch (AgentException unanswered) {
            if (!unanswered.code().equals("no-answer")) {
                throw unanswered;
            }
            throw new IOException(
                    "no answer, because the world is paused; "
                            + command
                            + " acts in its next frame",
                    unanswered);
        }
    }

    private static boolean isPaused(AgentClient client) {
        try {
            return client.report("state", Map.of()).content().get("paused") == Boolean.TRUE;
        } catch (AgentException unanswered) {
            return false; // the command itself then gets the answer
        }
    }

    private Map<String, Object> fields() throws IOException {
        Set<String> known = COMMANDS.getOrDefault(command, QUESTIONS.get(command));
        if (known == null) {
            String near = Suggestion.of(command, names());
            throw wrong(
                    "'"
                            + command
                            + "' is no command of the role control"
                            + (near.isEmpty()
                                    ? ", expected one of " + String.join(", ", names())
                                    : near));
        }
        Map<String, Object> fields = new LinkedHashMap<>();
        Map<String, Object> parameters = new LinkedHashMap<>();
        for (String each : given) {
            if (FROM_FILES.contains(command) && ControlFields.isFile(each)) {
                fields.putAll(ControlFields.read(command, Path.of(each)));
                continue;
            }
            if (command.equals("fork") && each.startsWith("file=")) {
                fields.putAll(ControlFields.read(command, Path.of(each.substring(5))));
                continue;
            }
            int equals = each.indexOf('=');
            if (equals < 1) {
                throw wrong(
                        "'"
                                + each
                                + "' is no field of "
                                + command
                                + ", expected FIELD=VALUE, e.g. image=calm");
            }
            String field = each.substring(0, equals);
            if (WITH_PARAMETERS.contains(command)
                    && (field.startsWith(PARAMETERS) || !known.contains(field))) {
                String name =
                        field.startsWith(PARAMETERS) ? field.substring(PARAMETERS.length()) : field;
                parameters.put(name, value(each.substring(equals + 1)));
                continue;
            }
            if (command.equals("change") && !field.equals("item")) {
                ControlFields.put(fields, "to." + field, value(each.substring(equals + 1)));
                continue;
            }
            if (!known.contains(field)) {
                throw wrong(
                        command
                                + " has no field '"
                                + field
                                + "'; it has "
                                + (known.isEmpty()
                                        ? "none"
                                        : String.join(", ", new TreeSet<>(known)))
                                + Suggestion.of(field, known));
            }
            Object value = value(field, each.substring(equals + 1));
            if (value != null) {
                fields.put(field, value);
            }
        }
        if (!parameters.isEmpty()) {
            fields.put("parameters", parameters);
        }
        if (fields.containsKey("file") && command.equals("load-law")) {
            fields.put("library", putText(fields, "a law text", "a law such as wind.law"));
        } else if (fields.containsKey("file") && command.equals("add-world")) {
            putText(fields, "a world file", "a world file such as world.yaml");
        }
        return fields;
    }

    private static Set<String> names() {
        Set<String> names = new TreeSet<>(COMMANDS.keySet());
        names.addAll(QUESTIONS.keySet());
        return names;
    }

    /**
     * Replaces the name of a file with the content of the file.
     *
     * @param kind what the file must contain, for messages
     * @param example an example of such a file, for messages
     * @return the name of the file without its folder
     */
    private String putText(Map<String, Object> fields, String kind, String example) {
        Path file = Path.of(String.valueOf(fields.remove("file")));
        try {
            if (Files.exists(file) && !Files.isRegularFile(file)) {
                throw wrong(file + " is a folder, a device or a pipe, expected a file");
            }
            if (Files.size(file) > MAX_TEXT_BYTES) {
                throw wrong(
                        file
                                + " has "
                                + Files.size(file)
                                + " bytes, expected "
                                + kind
                                + " of at most "
                                + MAX_TEXT_BYTES);
            }
            fields.put("text", Files.readString(file));
            return file.getFileName().toString();
        } catch (NoSuchFileException e) {
            throw wrong("there is no file " + file);
        } catch (MalformedInputException e) {
            throw wrong(file + " is no text in UTF-8, expected " + example);
        } catch (IOException e) {
            throw wrong(file + " cannot be read: " + e.getMessage());
        }
    }

    private ParameterException wrong(String problem) {
        return new ParameterException(spec.commandLine(), problem);
    }

    private static @Nullable Object value(String field, String text) {
        boolean removes = field.equals("rule") && text.equals("null");
        return TEXTS.contains(field) && !removes ? text : value(text);
    }

    private static @Nullable Object value(String text) {
        if (text.equals("null")) {
            return null;
        }
        if (text.equals("true") || text.equals("false")) {
            return Boolean.valueOf(text);
        }
        try {
            List<Double> numbers = new ArrayList<>();
            for (String part : text.split(",", -1)) {
                numbers.add(Double.valueOf(part));
            }
            return numbers.size() == 1 ? numbers.getFirst() : numbers;
        } catch (NumberFormatException noNumber) {
            return text;
        }
    }

    /** Prints the last frame of a copy of the world. */
    private void tell(Perception foreseen) {
        if (json) {
            List<Map<String, Object>> items = new ArrayList<>();
            for (Perception.Item item : foreseen.items()) {
                Map<String, Object> fields = new LinkedHashMap<>();
                fields.put("name", item.name());
                item.location().ifPresent(place -> fields.put("location", numbers(place)));
                Perception.Orientation turned = item.orientation();
                fields.put("orientation", List.of(turned.x(), turned.y(), turned.z(), turned.w()));
                fields.put("symbols", item.symbols());
                items.add(fields);
            }
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("frame", foreseen.frame());
            fields.put("time", foreseen.time());
            fields.put("items", items);
            Json.print(spec, fields);
            return;
        }
        Map<String, Object> places = new LinkedHashMap<>();
        for (Perception.Item item : foreseen.items()) {
            item.location().ifPresent(place -> places.put(item.name(), numbers(place)));
        }
        PrintWriter out = spec.commandLine().getOut();
        out.println(
                String.format(
                        Locale.ROOT,
                        "fork: frame %d, %.3f s; locations [m]:",
                        foreseen.frame(),
                        foreseen.time()));
        out.print(Json.text(places) + System.lineSeparator());
        out.flush();
    }

    private static List<Double> numbers(Perception.Location place) {
        return List.of(place.x(), place.y(), place.z());
    }

    private void tell(ActResult result) {
        PrintWriter out = spec.commandLine().getOut();
        if (json) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("accepted", result.accepted());
            result.frame().ifPresent(frame -> fields.put("frame", frame));
            result.value().ifPresent(value -> fields.put("value", value));
            result.code().ifPresent(code -> fields.put("code", code));
            result.reason().ifPresent(reason -> fields.put("reason", reason));
            Json.print(spec, fields);
        } else if (result.accepted()) {
            out.println(command + ": frame " + result.frame().orElseThrow());
            result.value().ifPresent(value -> out.print(Json.text(value) + System.lineSeparator()));
        } else {
            // The refusal of a law as text has several lines. Therefore line ends are printed, and
            // other control characters are escaped.
            String reason =
                    "reve: " + result.code().orElse("refused") + ": " + result.reason().orElse("");
            LinePrinter.message(spec.commandLine().getErr(), reason.lines().toList());
        }
        out.flush();
    }
}
