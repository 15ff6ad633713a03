package reve.agent;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.OptionalLong;
import java.util.function.Function;
import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ObjectNode;

/** How the messages of protocol version 1 are written, one JSON object per line. */
final class Protocol {

    static final int VERSION = 1;

    private static final int SHOWN = 200;
    private static final JsonMapper JSON = new JsonMapper();

    private Protocol() {}

    // ---- what a client says ----

    static String hello(Join join) {
        ObjectNode message = message("hello").put("protocol", VERSION).put("name", join.name());
        if (!join.role().equals("agent")) {
            message.put("role", join.role());
        }
        join.body().ifPresent(item -> message.put("body", item));
        if (join.grace().isPositive()) {
            message.put("graceSeconds", join.grace().toMillis() / 1000.0);
        }
        join.resume().ifPresent(resume -> message.putObject("resume")
                .put("session", resume.session()).put("frame", resume.frame()));
        return message.toString();
    }

    static String perceive(long id) {
        return message("perceive").put("id", id).toString();
    }

    static String perceiveWithRelations(long id) {
        return message("perceive").put("id", id).put("relations", true).toString();
    }

    /** @param every frames between perceptions, 0 for no more */
    static String perceive(long id, int every) {
        return message("perceive").put("id", id).put("every", every).toString();
    }

    static String act(long id, String item, String action, Map<String, ?> arguments) {
        ObjectNode values = JSON.createObjectNode();
        arguments.forEach((name, value) -> values.set(name, argument(name, value)));
        ObjectNode message = message("act").put("id", id).put("item", item).put("action", action);
        message.set("arguments", values);
        return message.toString();
    }

    /** What only the role control may say. */
    static String command(long id, String type, Map<String, ?> fields) {
        ObjectNode message = message(type).put("id", id);
        fields.forEach((name, value) -> message.set(name, value instanceof Map<?, ?> map
                ? JSON.valueToTree(map) : argument(name, value)));
        return message.toString();
    }

    static String ping(long id) {
        return message("ping").put("id", id).toString();
    }

    static String pong() {
        return message("pong").toString();
    }

    static String bye() {
        return message("bye").toString();
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
                                "argument " + name + " is a list with " + element + ", expected numbers only");
                    }
                    numbers.add(finite(name, number));
                }
                yield JSON.valueToTree(numbers);
            }
            default -> throw new IllegalArgumentException("argument " + name + " is a "
                    + value.getClass().getSimpleName() + ", expected a number, numbers, a text or a truth value");
        };
    }

    private static Number finite(String name, Number number) {
        if (!Double.isFinite(number.doubleValue())) {
            throw new IllegalArgumentException("argument " + name + " is " + number + ", expected a finite number");
        }
        return number;
    }

    // ---- what a server says ----

    /** @throws AgentException with code {@code protocol} if the line says nothing of version 1 */
    static ServerMessage read(String line) {
        try {
            JsonNode message = JSON.readTree(line);
            return switch (text(message, "t")) {
                case "welcome" -> welcome(message);
                case "perception" -> new Perception(id(message), message.required("frame").longValue(),
                        message.required("time").doubleValue(),
                        message.required("items").valueStream().map(Protocol::item).toList());
                case "result" -> result(message);
                case "event" -> new WorldEvent(message.required("frame").longValue(), text(message, "type"),
                        map(message.required("fields"), Protocol::value));
                case "error" -> new ServerMessage.Error(id(message), text(message, "code"), text(message, "message"),
                        optional(message, "hint"));
                case "ping" -> new ServerMessage.Ping();
                case "pong" -> new ServerMessage.Pong(id(message));
                case "bye" -> new ServerMessage.Bye(text(message, "code"), text(message, "message"),
                        optional(message, "hint"));
                default -> throw noMessage(line);
            };
        } catch (JacksonException | IllegalArgumentException e) {
            throw noMessage(line);
        }
    }

    private static AgentException noMessage(String line) {
        return new AgentException("protocol", "the server sent a line that is no message of protocol " + VERSION
                + ": " + line.substring(0, Math.min(SHOWN, line.length())), Optional.empty());
    }

    private static Welcome welcome(JsonNode message) {
        JsonNode limits = message.required("limits");
        return new Welcome(id(message), message.required("protocol").intValue(), text(message, "role"),
                text(message, "agent"), optional(message, "body"), text(message, "world"),
                message.required("frame").longValue(), message.required("rate").intValue(),
                message.optional("session").map(session -> new Welcome.Ticket(text(session, "token"),
                        session.required("graceSeconds").doubleValue())), message.path("resumed").asBoolean(false),
                new Welcome.Limits(limits.required("lineBytes").intValue(),
                        limits.required("actsInFlight").intValue(), limits.required("idleSeconds").doubleValue(),
                        limits.required("graceSeconds").doubleValue()));
    }

    private static ActResult result(JsonNode message) {
        long id = message.required("id").longValue();
        return message.required("accepted").booleanValue()
                ? new ActResult(id, true, OptionalLong.of(message.required("frame").longValue()), Optional.empty(),
                        Optional.empty())
                : new ActResult(id, false, OptionalLong.empty(), Optional.of(text(message, "code")),
                        Optional.of(text(message, "reason")));
    }

    private static Perception.Item item(JsonNode item) {
        Optional<Perception.Location> location = item.optional("location").map(at -> new Perception.Location(
                at.required(0).doubleValue(), at.required(1).doubleValue(), at.required(2).doubleValue()));
        return new Perception.Item(text(item, "name"), location, map(item.required("symbols"), Protocol::value),
                map(item.required("actions"), action -> map(action, Protocol::parameter)));
    }

    private static Perception.Parameter parameter(JsonNode parameter) {
        JsonNode components = parameter.path("components");
        return new Perception.Parameter(text(parameter, "type"),
                components.isNumber() ? OptionalInt.of(components.intValue()) : OptionalInt.empty(),
                optional(parameter, "unit"));
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
        return value.isArray() ? value.valueStream().map(Protocol::value).toList() : value.stringValue();
    }

    private static OptionalLong id(JsonNode message) {
        JsonNode id = message.path("id");
        return id.isNumber() ? OptionalLong.of(id.longValue()) : OptionalLong.empty();
    }

    private static String text(JsonNode message, String field) {
        return message.required(field).stringValue();
    }

    private static Optional<String> optional(JsonNode message, String field) {
        return message.optional(field).map(JsonNode::stringValue);
    }
}
