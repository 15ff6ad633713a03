// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import static reve.core.agent.protocol.ClientMessage.NO_ID;

import org.jspecify.annotations.Nullable;

import reve.core.frame.LawSwap;
import reve.core.frame.TimeBudget;
import reve.core.text.Visible;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;

import java.nio.ByteBuffer;
import java.nio.charset.CharacterCodingException;
import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.Set;
import java.util.regex.Pattern;

/** Parser of clients' messages. For any thread. */
public final class MessageReader {

    /** Maximum number of frames between two perceptions. */
    public static final int MAX_EVERY = 1_000_000;

    /** Maximum grace and deadline [s]. */
    public static final double MAX_SECONDS = 1e6;

    private static final double LEAST_MILLISECONDS = 0.001;
    private static final double MIN_SPEED = 0.01;
    private static final double MAX_SPEED = 100;
    private static final double DEFAULT_DEADLINE_SECONDS = 1;
    private static final long MAX_ID = (1L << 53) - 1;
    private static final int MAX_REASON = 200;

    /**
     * Matches the part of an error message in which the JSON library names its method that returns
     * a limit. This part is removed, because it does not help clients.
     */
    private static final Pattern METHOD = Pattern.compile(", from `[^`]*`");

    private static final int MAX_IMAGE_NAME = 64;
    private static final String EXAMPLE =
            "send one JSON object per line, such as "
                    + "{\"t\":\"hello\",\"protocol\":1,\"name\":\"ada\"}";

    private MessageReader() {}

    /**
     * Reads a message.
     *
     * @param bytes the message; the buffer must be backed by an array
     * @throws BadMessage with the reason, and with the id of the message if it is valid
     */
    public static ClientMessage read(ByteBuffer bytes, Encoding encoding) throws BadMessage {
        JsonNode message = encoding == Encoding.JSON ? parse(decode(bytes)) : unpack(bytes);
        if (!message.isObject()) {
            throw new BadMessage(NO_ID, "not-an-object", "the message is no object", EXAMPLE);
        }
        return read(message);
    }

    private static JsonNode unpack(ByteBuffer bytes) throws BadMessage {
        try {
            return MessagePackReader.read(bytes);
        } catch (IllegalArgumentException e) {
            throw new BadMessage(
                    NO_ID,
                    "bad-msgpack",
                    "this is no MessagePack: " + e.getMessage(),
                    "send 4 bytes of length, the highest first, and one map");
        }
    }

    private static String decode(ByteBuffer line) throws BadMessage {
        try {
            return Text.decode(
                    line.array(), line.arrayOffset() + line.position(), line.remaining());
        } catch (CharacterCodingException e) {
            throw new BadMessage(NO_ID, "bad-utf8", "the line is not UTF-8", EXAMPLE);
        }
    }

    private static JsonNode parse(String line) throws BadMessage {
        try {
            JsonNode node = Json.MAPPER.readTree(line);
            if (node.isMissingNode()) {
                throw badJson("the line is empty");
            }
            requireSound(node);
            return node;
        } catch (JacksonException e) {
            String reason = METHOD.matcher(e.getOriginalMessage()).replaceAll("");
            throw badJson(
                    "the line is not JSON: "
                            + (reason.length() > MAX_REASON
                                    ? reason.substring(0, MAX_REASON) + "…"
                                    : reason));
        }
    }

    /**
     * Refuses values that are valid JSON but that the server does not accept: numbers beyond the
     * range of doubles, and unpaired surrogates.
     */
    private static void requireSound(JsonNode node) throws BadMessage {
        if (node.isString()) {
            requireSound(node.stringValue());
        } else if (node.isNumber()) {
            if (!Double.isFinite(node.asDouble(Double.NaN))) {
                throw badJson("a number is beyond the range of 64-bit floats");
            }
        } else if (node.isContainer()) {
            for (Map.Entry<String, JsonNode> property : node.properties()) {
                requireSound(property.getKey());
            }
            for (JsonNode child : node.values()) {
                requireSound(child);
            }
        }
    }

    private static void requireSound(String text) throws BadMessage {
        for (int i = 0; i < text.length(); i++) {
            if (Character.isSurrogate(text.charAt(i))) {
                if (!Character.isSupplementaryCodePoint(text.codePointAt(i))) {
                    throw badJson("a text contains half of a surrogate pair");
                }
                i++;
            }
        }
    }

    private static BadMessage badJson(String message) {
        return new BadMessage(NO_ID, "bad-json", message, EXAMPLE);
    }

    private static ClientMessage read(JsonNode message) throws BadMessage {
        var fields = new Fields(message);
        JsonNode type = message.get("t");
        if (type == null || !type.isString()) {
            throw new BadMessage(
                    fields.id, "no-type", "the field t must say which message this is", EXAMPLE);
        }
        return switch (type.stringValue()) {
            case "hello" ->
                    new ClientMessage.Hello(
                            fields.id,
                            fields.protocol(),
                            fields.text("name"),
                            fields.optionalText("role").orElse("agent"),
                            fields.optionalText("world"),
                            fields.optionalText("body"),
                            fields.optionalText("encoding").orElse(Encoding.JSON.wireName()),
                            fields.has("graceSeconds")
                                    ? fields.number("graceSeconds", 0, MAX_SECONDS)
                                    : 0,
                            fields.lockStep(),
                            fields.resume(),
                            fields.optionalText("token"),
                            fields.optionalText("ask"));
            case "perceive" ->
                    new ClientMessage.Perceive(
                            fields.id,
                            fields.has("every")
                                    ? (int) fields.integer("every", 0, MAX_EVERY)
                                    : ClientMessage.Perceive.ONCE,
                            fields.isTrue("relations"));
            case "look" ->
                    new ClientMessage.Look(
                            fields.required(), fields.text("sensor"), fields.optionalText("item"));
            case "act" ->
                    new ClientMessage.Act(
                            fields.required(),
                            fields.requested(Optional.of(fields.text("item"))),
                            fields.isTrue("ready")
                                    ? Optional.of(fields.ready())
                                    : Optional.empty());
            case "ready" -> fields.ready();
            case "pause" -> new ClientMessage.Pause(fields.required());
            case "run" -> new ClientMessage.Run(fields.required());
            case "step" ->
                    new ClientMessage.Step(
                            fields.required(),
                            fields.has("frames")
                                    ? (int) fields.integer("frames", 1, MAX_EVERY)
                                    : 1);
            case "load-law" ->
                    new ClientMessage.LoadLaw(
                            fields.required(),
                            fields.has("text") && !fields.has("library")
                                    ? "text"
                                    : fields.text("library"),
                            fields.optionalText("text"),
                            fields.parameters(),
                            fields.swap());
            case "unload-law" ->
                    new ClientMessage.UnloadLaw(fields.required(), fields.text("library"));
            case "edit" ->
                    new ClientMessage.Edit(
                            fields.required(),
                            fields.text("item"),
                            fields.text("property"),
                            fields.value());
            case "add", "change", "remove", "rule" -> fields.change(fields.required());
            case "batch" -> fields.batch();
            case "picture" -> new ClientMessage.Picture(fields.required());
            case "snapshot" -> new ClientMessage.Snapshot(fields.required(), fields.image());
            case "rewind" ->
                    new ClientMessage.Rewind(fields.required(), fields.optionalText("image"));
            case "save" -> new ClientMessage.Save(fields.required(), fields.text("file"));
            case "fork" ->
                    new ClientMessage.Fork(
                            fields.required(),
                            (int) fields.integer("frames", 0, MAX_EVERY),
                            fields.has("changes") ? Optional.of(fields.batch()) : Optional.empty());
            case "profile", "cluster", "changes", "near", "region" -> fields.ask();
            case "move-world" ->
                    new ClientMessage.MoveWorld(
                            fields.required(), fields.text("world"), fields.text("node"));
            case "drain-node" ->
                    new ClientMessage.DrainNode(
                            fields.required(),
                            fields.text("node"),
                            !fields.has("drained") || fields.isTrue("drained"));
            case "add-world" ->
                    new ClientMessage.AddWorld(
                            fields.required(), fields.text("text"), fields.isTrue("asleep"));
            case "release" -> new ClientMessage.Release(fields.required(), fields.text("library"));
            case "shut-down" -> new ClientMessage.ShutDown(fields.required());
            case "speed" ->
                    new ClientMessage.Speed(
                            fields.required(), fields.number("factor", MIN_SPEED, MAX_SPEED));
            case "set-law" ->
                    new ClientMessage.SetLaw(
                            fields.required(),
                            fields.text("library"),
                            fields.parameters(),
                            fields.swap());
            case "set-budget" ->
                    new ClientMessage.SetBudget(
                            fields.required(), fields.text("library"), fields.budget());
            case "state" -> new ClientMessage.State(fields.required(), fields.isTrue("roundTrips"));
            case "inspect" -> new ClientMessage.Inspect(fields.required(), fields.text("item"));
            case "perceived" ->
                    new ClientMessage.Perceived(fields.required(), fields.text("client"));
            case "search" -> new ClientMessage.Search(fields.required(), fields.text("text"));
            case "laws" -> new ClientMessage.Laws(fields.required());
            case "ledger" ->
                    new ClientMessage.Ledger(
                            fields.required(),
                            fields.has("open")
                                    ? Optional.of(fields.isTrue("open"))
                                    : Optional.empty());
            case "audit" ->
                    new ClientMessage.Audit(
                            fields.required(),
                            fields.optionalText("client"),
                            fields.isTrue("frequent"),
                            fields.has("most")
                                    ? (int) fields.integer("most", 1, ClientMessage.Audit.MAX)
                                    : ClientMessage.Audit.DEFAULT);
            case "ping" -> new ClientMessage.Ping(fields.id);
            case "pong" -> new ClientMessage.Pong(fields.id);
            case "bye" -> new ClientMessage.Bye(fields.id);
            default ->
                    throw new BadMessage(
                            fields.id,
                            "unknown-type",
                            "there is no message "
                                    + Text.quote(type.stringValue())
                                    + " in protocol 1",
                            "a client sends hello, perceive, look, act, ready, ping, pong or bye;"
                                    + " in the roles observer and control also state, inspect, search,"
                                    + " laws or perceived; in the role control also pause, run, step, speed,"
                                    + " load-law, set-law, set-budget, unload-law, release, edit, add, change,"
                                    + " remove, rule, batch, picture, snapshot, rewind, save, fork,"
                                    + " ledger, audit, profile, cluster, move-world, drain-node,"
                                    + " add-world, changes, near, region or shut-down");
        };
    }

    /** The fields of one message; a field with the value null counts as absent. */
    private static final class Fields {

        private final JsonNode message;
        private final long id;

        Fields(JsonNode message) throws BadMessage {
            this.message = message;
            this.id = find("id") == null ? NO_ID : integer(NO_ID, "id", 0, MAX_ID);
        }

        /**
         * Reads an object inside a message. Errors in the object refer to the id of the message.
         */
        Fields(JsonNode part, long id) {
            this.message = part;
            this.id = id;
        }

        boolean has(String name) {
            return find(name) != null;
        }

        /** Returns the version of the protocol that the client's hello requests. */
        int protocol() throws BadMessage {
            if (!has("protocol")) {
                throw bad(
                        id,
                        "protocol",
                        "is missing",
                        "expected " + ClientMessage.PROTOCOL + ", as in " + EXAMPLE);
            }
            return (int) integer("protocol", 0, Integer.MAX_VALUE);
        }

        /** Returns the id of a message whose type requires one. */
        long required() throws BadMessage {
            return integer("id", 0, MAX_ID);
        }

        long integer(String name, long min, long max) throws BadMessage {
            return integer(id, name, min, max);
        }

        double number(String name, double min, double max) throws BadMessage {
            JsonNode field = find(name);
            double value = field != null && field.isNumber() ? field.asDouble() : Double.NaN;
            if (!(value >= min && value <= max)) {
                throw bad(
                        id,
                        name,
                        field == null ? "is missing" : "is " + show(field),
                        "expected a number from " + min + " to " + max);
            }
            return value;
        }

        Optional<ClientMessage.LockStep> lockStep() throws BadMessage {
            JsonNode field = find("time");
            if (field == null) {
                return Optional.empty();
            }
            if (!field.isObject()) {
                throw bad(id, "time", "is " + show(field), "expected an object with mode");
            }
            var time = new Fields(field);
            return switch (time.text("mode")) {
                case "real-time" -> Optional.empty();
                case "lock-step" -> {
                    if (!optionalText("role").orElse("agent").equals("agent")) {
                        throw bad(
                                id,
                                "mode",
                                "is \"lock-step\"",
                                "expected \"real-time\" for this role");
                    }
                    yield Optional.of(
                            new ClientMessage.LockStep(
                                    time.has("every")
                                            ? (int) time.integer("every", 1, MAX_EVERY)
                                            : 1,
                                    time.isTrue("relations"),
                                    time.has("deadline")
                                            ? time.number("deadline", 0, MAX_SECONDS)
                                            : DEFAULT_DEADLINE_SECONDS,
                                    time.fallback()));
                }
                default ->
                        throw bad(
                                id,
                                "mode",
                                "is " + show(field.get("mode")),
                                "expected \"real-time\" or \"lock-step\"");
            };
        }

        private Optional<ActionRequest> fallback() throws BadMessage {
            JsonNode field = find("fallback");
            if (field == null) {
                return Optional.empty();
            }
            if (!field.isObject()) {
                throw bad(id, "fallback", "is " + show(field), "expected an object with action");
            }
            var fallback = new Fields(field);
            return Optional.of(fallback.requested(fallback.optionalText("item")));
        }

        ActionRequest requested(Optional<String> item) throws BadMessage {
            return new ActionRequest(item, text("action"), arguments());
        }

        ClientMessage.Ready ready() throws BadMessage {
            return new ClientMessage.Ready(
                    id,
                    has("frame")
                            ? OptionalLong.of(integer("frame", 0, MAX_ID))
                            : OptionalLong.empty());
        }

        Optional<ClientMessage.Resume> resume() throws BadMessage {
            JsonNode field = find("resume");
            if (field == null) {
                return Optional.empty();
            }
            if (!field.isObject()) {
                throw bad(
                        id,
                        "resume",
                        "is " + show(field),
                        "expected an object with session and frame");
            }
            var resume = new Fields(field);
            return Optional.of(
                    new ClientMessage.Resume(
                            resume.text("session"), resume.integer("frame", 0, MAX_ID)));
        }

        /**
         * Returns values by parameter name. A list sets the three parameters of a vector, whose
         * names end in {@code _x}, {@code _y} and {@code _z}.
         */
        Map<String, Double> parameters() throws BadMessage {
            var parameters = new LinkedHashMap<String, Double>();
            for (Map.Entry<String, JsonNode> parameter : object("parameters")) {
                JsonNode value = parameter.getValue();
                if (value.isArray() && value.size() != 3 || !value.isArray() && !value.isNumber()) {
                    throw bad(
                            id,
                            "parameters",
                            "holds " + show(value) + " for " + Text.quote(parameter.getKey()),
                            "expected a number, or the three numbers of a vector, in SI units");
                }
                if (value.isNumber()) {
                    parameters.put(parameter.getKey(), value.asDouble());
                    continue;
                }
                List<Double> numbers = numbers("parameters", parameter.getKey(), value);
                for (int i = 0; i < 3; i++) {
                    parameters.put(parameter.getKey() + "_" + "xyz".charAt(i), numbers.get(i));
                }
            }
            return parameters;
        }

        /**
         * Returns the way in which a new version of a law replaces the old one; empty if the
         * message does not state it.
         */
        Optional<LawSwap> swap() throws BadMessage {
            Optional<String> given = optionalText("swap");
            if (given.isEmpty()) {
                return Optional.empty();
            }
            Optional<LawSwap> swap = LawSwap.find(given.get());
            if (swap.isEmpty()) {
                throw bad(
                        id, "swap", "is " + Text.quote(given.get()), "expected shadow or at-once");
            }
            return swap;
        }

        /**
         * Returns the budget of a library. The result is empty if the message has no field {@code
         * milliseconds}.
         */
        Optional<TimeBudget> budget() throws BadMessage {
            if (!has("milliseconds")) {
                return Optional.empty();
            }
            double seconds =
                    number("milliseconds", LEAST_MILLISECONDS, TimeBudget.MOST_SECONDS * 1e3) / 1e3;
            String then = optionalText("then").orElse(TimeBudget.Response.WARN.text());
            TimeBudget.Response response =
                    TimeBudget.Response.find(then)
                            .orElseThrow(
                                    () ->
                                            bad(
                                                    id,
                                                    "then",
                                                    "is " + Text.quote(then),
                                                    "expected warn, unload or skip-steps"));
            return Optional.of(
                    TimeBudget.of(
                            seconds,
                            has("frames")
                                    ? (int) integer("frames", 1, TimeBudget.MOST_FRAMES)
                                    : TimeBudget.DEFAULT_FRAMES,
                            response,
                            has("every")
                                    ? (int) integer("every", 2, TimeBudget.MOST_EVERY)
                                    : TimeBudget.DEFAULT_EVERY));
        }

        Object value() throws BadMessage {
            JsonNode field = find("value");
            if (field == null) {
                throw bad(
                        id,
                        "value",
                        "is missing",
                        "expected a number, a list of numbers, a text, or true or false");
            }
            return value("value", "value", field);
        }

        /** Returns a change of items or rules, by the type of the message. */
        ClientMessage.WorldChange change(long answerTo) throws BadMessage {
            return switch (text("t")) {
                case "add" -> new ClientMessage.Add(answerTo, items());
                case "change" ->
                        new ClientMessage.Change(
                                answerTo, text("item"), mapping("to", message.get("to")));
                case "remove" ->
                        new ClientMessage.Remove(answerTo, text("item"), isTrue("cascade"));
                case "rule" -> new ClientMessage.SetRule(answerTo, text("name"), rule());
                default ->
                        throw bad(
                                id,
                                "t",
                                "is " + show(message.get("t")),
                                "expected add, change, remove or rule in a batch");
            };
        }

        ClientMessage.Batch batch() throws BadMessage {
            long answerTo = required();
            JsonNode list = find("changes");
            if (list == null
                    || !list.isArray()
                    || list.isEmpty()
                    || list.size() > ClientMessage.Batch.MAX) {
                throw bad(
                        id,
                        "changes",
                        list == null ? "is missing" : "does not fit",
                        "expected a list of 1 to " + ClientMessage.Batch.MAX + " changes");
            }
            List<ClientMessage.WorldChange> changes = new ArrayList<>();
            for (JsonNode each : list.values()) {
                if (!each.isObject()) {
                    throw bad(id, "changes", "holds " + show(each), "expected objects with t");
                }
                changes.add(new Fields(each, answerTo).change(ClientMessage.NO_ID));
            }
            return new ClientMessage.Batch(answerTo, changes);
        }

        /** Returns a question with its arguments. */
        ClientMessage.Ask ask() throws BadMessage {
            String what = text("t");
            Map<String, Object> arguments = new LinkedHashMap<>();
            for (String name : ClientMessage.Ask.QUESTIONS.get(what)) {
                boolean optional = name.endsWith("*");
                String key = optional ? name.substring(0, name.length() - 1) : name;
                JsonNode given = find(key);
                if (given != null) {
                    arguments.put(key, value(key, key, given));
                } else if (!optional) {
                    throw bad(id, key, "is missing", "expected a value");
                }
            }
            return new ClientMessage.Ask(required(), what, arguments);
        }

        /**
         * Returns the fields {@code items} and {@code prefabs} of a message that adds items, as
         * JSON.
         */
        private String items() throws BadMessage {
            JsonNode items = find("items");
            if (items == null || !items.isArray() || items.isEmpty()) {
                throw bad(
                        id,
                        "items",
                        items == null ? "is missing" : "is " + show(items),
                        "expected a list of items as in a world file");
            }
            JsonNode prefabs = find("prefabs");
            return "{\"items\":"
                    + items
                    + (prefabs == null ? "" : ",\"prefabs\":" + mapping("prefabs", prefabs))
                    + "}";
        }

        /**
         * Returns the rule in the message as JSON; empty if there is none, so that the rule is
         * removed.
         */
        private Optional<String> rule() throws BadMessage {
            JsonNode rule = find("rule");
            if (rule != null && !rule.isString() && !rule.isObject()) {
                throw bad(
                        id,
                        "rule",
                        "is " + show(rule),
                        "expected an expression, or an object with is");
            }
            return Optional.ofNullable(rule).map(JsonNode::toString);
        }

        private String mapping(String name, @Nullable JsonNode value) throws BadMessage {
            if (value == null || !value.isObject()) {
                throw bad(
                        id,
                        name,
                        value == null ? "is missing" : "is " + show(value),
                        "expected an object as in a world file");
            }
            return value.toString();
        }

        String text(String name) throws BadMessage {
            return optionalText(name)
                    .orElseThrow(() -> bad(id, name, "is missing", "expected a text"));
        }

        Optional<String> optionalText(String name) throws BadMessage {
            JsonNode field = find(name);
            if (field == null) {
                return Optional.empty();
            }
            if (!field.isString() || field.stringValue().isEmpty()) {
                throw bad(id, name, "is " + show(field), "expected a text");
            }
            return Optional.of(field.stringValue());
        }

        String image() throws BadMessage {
            String name = text("image");
            if (name.length() > MAX_IMAGE_NAME) {
                throw bad(
                        id,
                        "image",
                        "has " + name.length() + " characters",
                        "expected at most " + MAX_IMAGE_NAME);
            }
            return name;
        }

        /** Returns the value of a boolean field; false if the field is absent. */
        boolean isTrue(String name) throws BadMessage {
            return has(name) && truth(name);
        }

        private boolean truth(String name) throws BadMessage {
            JsonNode field = find(name);
            if (field == null || !field.isBoolean()) {
                throw bad(id, name, "is " + show(field), "expected true or false");
            }
            return field.booleanValue();
        }

        Map<String, Object> arguments() throws BadMessage {
            var arguments = new LinkedHashMap<String, Object>();
            for (Map.Entry<String, JsonNode> argument : object("arguments")) {
                arguments.put(
                        argument.getKey(),
                        value("arguments", argument.getKey(), argument.getValue()));
            }
            return arguments;
        }

        private Set<Map.Entry<String, JsonNode>> object(String name) throws BadMessage {
            JsonNode field = find(name);
            if (field == null) {
                return Set.of();
            }
            if (!field.isObject()) {
                throw bad(
                        id,
                        name,
                        "is " + show(field),
                        "expected an object of values by parameter name");
            }
            return field.properties();
        }

        private Object value(String in, String name, JsonNode value) throws BadMessage {
            if (value.isString()) {
                return value.stringValue();
            }
            if (value.isBoolean()) {
                return value.booleanValue();
            }
            return value.isArray() ? numbers(in, name, value) : number(in, name, value);
        }

        private List<Double> numbers(String in, String name, JsonNode value) throws BadMessage {
            var numbers = new ArrayList<Double>(value.size());
            for (JsonNode element : value.values()) {
                numbers.add(number(in, name, element));
            }
            return numbers;
        }

        private Double number(String in, String name, JsonNode value) throws BadMessage {
            if (!value.isNumber()) {
                throw bad(
                        id,
                        in,
                        "holds " + show(value) + " for " + Text.quote(name),
                        "expected a number, a list of numbers, a text, or true or false");
            }
            return value.asDouble();
        }

        private long integer(long answerTo, String name, long min, long max) throws BadMessage {
            JsonNode field = find(name);
            double value = field != null && field.isNumber() ? field.asDouble() : Double.NaN;
            if (!(value >= min && value <= max && value == Math.rint(value))) {
                throw bad(
                        answerTo,
                        name,
                        field == null ? "is missing" : "is " + show(field),
                        "expected an integer from " + min + " to " + max);
            }
            return (long) value;
        }

        private @Nullable JsonNode find(String name) {
            JsonNode field = message.get(name);
            return field == null || field.isNull() ? null : field;
        }

        private static BadMessage bad(long answerTo, String name, String found, String expected) {
            return new BadMessage(
                    answerTo, "bad-field", "the field " + name + " " + found, expected);
        }

        private static String show(JsonNode field) {
            return field.isString()
                    ? Text.quote(field.stringValue())
                    : Visible.shortened(field.toString());
        }
    }
}
