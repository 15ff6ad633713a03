// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import tools.jackson.core.JacksonException;
import tools.jackson.core.type.TypeReference;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ObjectNode;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.OptionalInt;
import java.util.OptionalLong;
import java.util.function.Function;

/** The messages of protocol version 1, as trees for JSON or MessagePack. */
final class Protocol {

    static final int VERSION = 1;

    /** Name of the act with which an agent speaks. */
    static final String SAY = "say";

    private static final int SHOWN = 200;
    private static final JsonMapper JSON = new JsonMapper();

    private Protocol() {}

    static ObjectNode hello(Join join) {
        ObjectNode message = message("hello").put("protocol", VERSION).put("name", join.name());
        if (!join.role().equals("agent")) {
            message.put("role", join.role());
        }
        join.world().ifPresent(world -> message.put("world", world));
        join.body().ifPresent(item -> message.put("body", item));
        if (join.encoding() != Encoding.JSON) {
            message.put("encoding", join.encoding().wireName());
        }
        if (join.grace().isPositive()) {
            message.put("graceSeconds", join.grace().toMillis() / 1000.0);
        }
        join.lockStep().ifPresent(lockStep -> putTime(message.putObject("time"), lockStep));
        join.resume()
                .ifPresent(
                        resume ->
                                message.putObject("resume")
                                        .put("session", resume.session())
                                        .put("frame", resume.frame()));
        join.token().ifPresent(token -> message.put("token", token));
        return message;
    }

    /** A hello that asks a question instead of joining a world. The answer has the id 1. */
    static ObjectNode ask(Join join, String question) {
        return hello(join).put("id", 1).put("ask", question);
    }

    private static void putTime(ObjectNode time, LockStep lockStep) {
        time.put("mode", "lock-step");
        if (lockStep.every() != 1) {
            time.put("every", lockStep.every());
        }
        if (lockStep.relations()) {
            time.put("relations", true);
        }
        if (!lockStep.deadline().equals(LockStep.DEADLINE)) {
            time.put("deadline", lockStep.deadline().toNanos() / 1e9);
        }
        lockStep.fallback()
                .ifPresent(
                        act -> {
                            ObjectNode fallback = time.putObject("fallback");
                            act.item().ifPresent(item -> fallback.put("item", item));
                            fallback.put("action", act.action())
                                    .set("arguments", arguments(act.arguments()));
                        });
    }

    static ObjectNode perceive(long id) {
        return message("perceive").put("id", id);
    }

    static ObjectNode perceiveWithRelations(long id) {
        return message("perceive").put("id", id).put("relations", true);
    }

    /**
     * Returns a request for a stream of perceptions.
     *
     * @param every frames between perceptions, 0 to end the stream
     */
    static ObjectNode perceive(long id, int every) {
        return message("perceive").put("id", id).put("every", every);
    }

    static ObjectNode look(long id, String sensor) {
        return message("look").put("id", id).put("sensor", sensor);
    }

    static ObjectNode act(long id, String item, String action, Map<String, ?> arguments) {
        ObjectNode message = message("act").put("id", id).put("item", item).put("action", action);
        message.set("arguments", arguments(arguments));
        return message;
    }

    private static ObjectNode arguments(Map<String, ?> arguments) {
        ObjectNode values = JSON.createObjectNode();
        arguments.forEach((name, value) -> values.set(name, argument(name, value)));
        return values;
    }

    /** Returns an act that also ends the round. */
    static ObjectNode andReady(ObjectNode act, OptionalLong frame) {
        act.put("ready", true);
        frame.ifPresent(seen -> act.put("frame", seen));
        return act;
    }

    /**
     * Returns the message {@code ready}.
     *
     * @param frame frame of the perception on which the agent's decision is based
     */
    static ObjectNode ready(OptionalLong frame) {
        ObjectNode message = message("ready");
        frame.ifPresent(seen -> message.put("frame", seen));
        return message;
    }

    /** Returns a command for the role control. */
    static ObjectNode command(long id, String type, Map<String, ?> fields) {
        ObjectNode message = message(type).put("id", id);
        fields.forEach(
                (name, value) ->
                        message.set(
                                name,
                                value instanceof Map<?, ?> || isOfMappings(value)
                                        ? JSON.valueToTree(value)
                                        : argument(name, value)));
        return message;
    }

    /** Returns whether a value is a list of messages (items or changes) instead of numbers. */
    private static boolean isOfMappings(Object value) {
        return value instanceof List<?> list
                && list.stream().anyMatch(element -> element instanceof Map<?, ?>);
    }

    static ObjectNode ping(long id) {
        return message("ping").put("id", id);
    }

    static ObjectNode pong() {
        return message("pong");
    }

    static ObjectNode bye() {
        return message("bye");
    }

    private static ObjectNode message(String type) {
        return JSON.createObjectNode().put("t", type);
    }

    private static JsonNode argument(String name, Object value) {
        return switch (value) {
            case String text -> JSON.valueToTree(text);
            case Boolean truth -> JSON.valueToTree(truth);
            case Number number -> JSON.valueToTree(finite(name, number));
            case double[] numbers -> argument(name, Arrays.stream(numbers).boxed().toList());
            case List<?> list -> {
                var numbers = new ArrayList<Number>();
                for (Object element : list) {
                    if (!(element instanceof Number number)) {
                        throw new IllegalArgumentException(
                                "argument "
                                        + name
                                        + " is a list with "
                                        + element
                                        + ", expected numbers only");
                    }
                    numbers.add(finite(name, number));
                }
                yield JSON.valueToTree(numbers);
            }
            default ->
                    throw new IllegalArgumentException(
                            "argument "
                                    + name
                                    + " is a "
                                    + value.getClass().getSimpleName()
                                    + ", expected a number, numbers, a text or a truth value");
        };
    }

    private static Number finite(String name, Number number) {
        if (!Double.isFinite(number.doubleValue())) {
            throw new IllegalArgumentException(
                    "argument " + name + " is " + number + ", expected a finite number");
        }
        return number;
    }

    /**
     * Reads one message from a line of JSON.
     *
     * @throws AgentException with code {@code protocol} if the line is not a message of version 1
     */
    static ServerMessage read(String line) {
        try {
            return read(JSON.readTree(line));
        } catch (JacksonException | IllegalArgumentException e) {
            throw noMessage(line);
        }
    }

    /**
     * Reads one message.
     *
     * @param packed MessagePack, the bytes behind the length prefix
     * @throws AgentException with code {@code protocol} if it is not a message of version 1
     */
    static ServerMessage read(byte[] packed) {
        try {
            return read(Packed.read(packed));
        } catch (IOException | RuntimeException | StackOverflowError e) {
            throw noMessage("MessagePack of " + packed.length + " bytes: " + e.getMessage());
        }
    }

    private static ServerMessage read(JsonNode message) {
        return switch (text(message, "t")) {
            case "welcome" -> welcome(message);
            case "perception" -> message.has("since") ? update(message) : perception(message);
            case "image" -> image(message);
            case "report" ->
                    new Report(
                            message.required("id").longValue(),
                            message.required("frame").longValue(),
                            text(message, "of"),
                            JSON.convertValue(
                                    message.required("content"),
                                    new TypeReference<Map<String, Object>>() {}));
            case "result" -> result(message);
            case "event" ->
                    new WorldEvent(
                            message.required("frame").longValue(),
                            text(message, "type"),
                            map(message.required("fields"), Protocol::value));
            case "error" ->
                    new ServerMessage.Error(
                            id(message),
                            text(message, "code"),
                            text(message, "message"),
                            optional(message, "hint"));
            case "ping" -> new ServerMessage.Ping();
            case "pong" -> new ServerMessage.Pong(id(message));
            case "bye" ->
                    new ServerMessage.Bye(
                            text(message, "code"),
                            text(message, "message"),
                            optional(message, "hint"),
                            optional(message, "address"));
            default -> throw new IllegalArgumentException("there is no such message");
        };
    }

    private static AgentException noMessage(String line) {
        return new AgentException(
                "protocol",
                "the server sent what is no message of protocol "
                        + VERSION
                        + ": "
                        + line.substring(0, Math.min(SHOWN, line.length())),
                Optional.empty());
    }

    private static Perception perception(JsonNode message) {
        return new Perception(
                id(message),
                message.required("frame").longValue(),
                message.required("time").doubleValue(),
                list(message.required("items"), Protocol::item),
                map(message.path("readings"), Protocol::reading));
    }

    private static Update update(JsonNode message) {
        return new Update(
                id(message),
                message.required("frame").longValue(),
                message.required("time").doubleValue(),
                message.required("since").longValue(),
                list(message.path("left"), JsonNode::stringValue),
                list(message.path("entered"), Protocol::item),
                list(message.path("changed"), Protocol::change),
                map(message.path("readings"), Protocol::reading));
    }

    private static Perception.Reading reading(JsonNode reading) {
        var quantities = new LinkedHashMap<String, DoubleBuffer>();
        for (Map.Entry<String, JsonNode> field : reading.properties()) {
            if (field.getValue().isArray()) {
                double[] numbers =
                        field.getValue().valueStream().mapToDouble(JsonNode::doubleValue).toArray();
                if (field.getKey().equals("distances")) {
                    Arrays.setAll(
                            numbers, i -> numbers[i] < 0 ? Double.POSITIVE_INFINITY : numbers[i]);
                }
                quantities.put(field.getKey(), DoubleBuffer.wrap(numbers).asReadOnlyBuffer());
            }
        }
        return new Perception.Reading(
                reading.required("frame").longValue(),
                Collections.unmodifiableMap(quantities),
                integer(reading, "columns"));
    }

    private static <T> List<T> list(JsonNode list, Function<JsonNode, T> read) {
        return list.valueStream().map(read).toList();
    }

    private static Welcome welcome(JsonNode message) {
        return new Welcome(
                id(message),
                message.required("protocol").intValue(),
                text(message, "role"),
                text(message, "agent"),
                optional(message, "body"),
                text(message, "world"),
                message.required("frame").longValue(),
                message.required("rate").intValue(),
                text(message, "encoding", Encoding.JSON.wireName()),
                message.optional("time").map(Protocol::lockStep),
                message.optional("session").map(Protocol::ticket),
                message.path("resumed").asBoolean(false),
                limits(message.required("limits")),
                list(message.path("cameras"), JsonNode::stringValue));
    }

    private static Welcome.Ticket ticket(JsonNode session) {
        return new Welcome.Ticket(
                text(session, "token"),
                session.required("graceSeconds").doubleValue(),
                list(session.path("servers"), JsonNode::stringValue));
    }

    private static Welcome.Limits limits(JsonNode limits) {
        return new Welcome.Limits(
                limits.required("lineBytes").intValue(),
                limits.required("messagesPerSecond").intValue(),
                limits.required("actsInFlight").intValue(),
                limits.required("idleSeconds").doubleValue(),
                limits.required("graceSeconds").doubleValue(),
                integer(limits, "items"),
                integer(limits, "worldItems"),
                integer(limits, "eventBytes"),
                integer(limits, "worldEventBytes"));
    }

    private static LockStep lockStep(JsonNode time) {
        return LockStep.every(time.required("every").intValue())
                .withDeadline(
                        Duration.ofNanos(
                                Math.round(1e9 * time.required("deadline").doubleValue())));
    }

    private static Image image(JsonNode message) {
        return new Image(
                message.required("id").longValue(),
                message.required("frame").longValue(),
                message.required("time").doubleValue(),
                text(message, "sensor"),
                message.required("width").intValue(),
                message.required("height").intValue(),
                message.optional("colour").map(Protocol::bytes),
                message.optional("depth").map(Protocol::bytes),
                message.optional("items").map(Protocol::bytes),
                list(message.path("names"), JsonNode::stringValue));
    }

    private static ByteBuffer bytes(JsonNode layer) {
        return ByteBuffer.wrap(layer.binaryValue())
                .asReadOnlyBuffer()
                .order(ByteOrder.LITTLE_ENDIAN);
    }

    private static ActResult result(JsonNode message) {
        long id = message.required("id").longValue();
        return message.required("accepted").booleanValue()
                ? new ActResult(
                        id,
                        true,
                        OptionalLong.of(message.required("frame").longValue()),
                        Optional.empty(),
                        Optional.empty(),
                        message.optional("value")
                                .map(value -> JSON.treeToValue(value, Object.class)))
                : new ActResult(
                        id,
                        false,
                        OptionalLong.empty(),
                        Optional.of(text(message, "code")),
                        Optional.of(text(message, "reason")),
                        Optional.empty());
    }

    private static Perception.Item item(JsonNode item) {
        Update.Change change = change(item);
        return new Perception.Item(
                change.name(),
                change.location(),
                change.orientation().orElse(Perception.Orientation.NONE),
                change.symbols().orElse(Map.of()),
                change.actions().orElse(Map.of()),
                change.needs().orElse(Map.of()),
                list(item.path("capabilities"), JsonNode::stringValue));
    }

    private static Update.Change change(JsonNode item) {
        return new Update.Change(
                text(item, "name"),
                item.optional("location").map(Protocol::location),
                item.optional("orientation").map(Protocol::orientation),
                item.optional("symbols").map(all -> map(all, Protocol::value)),
                item.optional("actions")
                        .map(all -> map(all, action -> map(action, Protocol::parameter))),
                item.optional("needs")
                        .map(all -> map(all, names -> list(names, JsonNode::stringValue))));
    }

    private static Perception.Location location(JsonNode at) {
        return new Perception.Location(number(at, 0), number(at, 1), number(at, 2));
    }

    private static Perception.Orientation orientation(JsonNode turn) {
        return new Perception.Orientation(
                number(turn, 0), number(turn, 1), number(turn, 2), number(turn, 3));
    }

    private static double number(JsonNode list, int index) {
        return list.required(index).doubleValue();
    }

    private static Perception.Parameter parameter(JsonNode parameter) {
        return new Perception.Parameter(
                text(parameter, "type"),
                integer(parameter, "components"),
                optional(parameter, "unit"),
                bound(parameter, "min"),
                bound(parameter, "max"));
    }

    private static OptionalInt integer(JsonNode object, String which) {
        JsonNode integer = object.path(which);
        return integer.isNumber() ? OptionalInt.of(integer.intValue()) : OptionalInt.empty();
    }

    private static OptionalDouble bound(JsonNode parameter, String which) {
        JsonNode bound = parameter.path(which);
        return bound.isNumber() ? OptionalDouble.of(bound.doubleValue()) : OptionalDouble.empty();
    }

    private static <T> Map<String, T> map(JsonNode object, Function<JsonNode, T> read) {
        var map = new LinkedHashMap<String, T>();
        object.properties().forEach(entry -> map.put(entry.getKey(), read.apply(entry.getValue())));
        return Collections.unmodifiableMap(map);
    }

    private static Object value(JsonNode value) {
        if (value.isNumber()) {
            return value.doubleValue();
        }
        if (value.isBoolean()) {
            return value.booleanValue();
        }
        return value.isArray()
                ? value.valueStream().map(Protocol::value).toList()
                : value.stringValue();
    }

    private static OptionalLong id(JsonNode message) {
        JsonNode id = message.path("id");
        return id.isNumber() ? OptionalLong.of(id.longValue()) : OptionalLong.empty();
    }

    private static String text(JsonNode message, String field) {
        return message.required(field).stringValue();
    }

    private static String text(JsonNode message, String field, String otherwise) {
        return optional(message, field).orElse(otherwise);
    }

    private static Optional<String> optional(JsonNode message, String field) {
        return message.optional(field).map(JsonNode::stringValue);
    }
}
