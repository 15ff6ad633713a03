// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.MethodSource;
import org.junit.jupiter.params.provider.ValueSource;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.ObjectNode;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.DoubleBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Base64;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.function.BiFunction;
import java.util.stream.Stream;

/** The protocol's test vectors, which every client must reproduce. */
class ProtocolTest {

    private static final JsonMapper JSON = new JsonMapper();

    static Stream<JsonNode> clientMessages() throws IOException {
        return vectors("client.jsonl");
    }

    static Stream<JsonNode> serverMessages() throws IOException {
        return vectors("server.jsonl");
    }

    static Stream<JsonNode> sessionMessages() throws IOException {
        return vectors("session.jsonl")
                .filter(line -> line.has("server"))
                .map(line -> line.get("server"));
    }

    static Stream<JsonNode> lenientServerMessages() throws IOException {
        return vectors("lenient.jsonl")
                .filter(vector -> vector.get("from").stringValue().equals("server"));
    }

    @ParameterizedTest
    @MethodSource("clientMessages")
    void whatTheClientSaysIsWrittenAsDocumented(JsonNode message) {
        assertSame(JSON.readTree(said(message).toString()), message);
    }

    @ParameterizedTest
    @MethodSource({"serverMessages", "sessionMessages"})
    void whatTheServerSaysIsUnderstood(JsonNode message) {
        assertSame(written(Protocol.read(message.toString())), understood(message));
    }

    static Stream<JsonNode> packedMessages() throws IOException {
        return vectors("packed.jsonl");
    }

    @ParameterizedTest
    @MethodSource("packedMessages")
    void messagePackSaysTheSame(JsonNode vector) throws IOException {
        byte[] frame = HexFormat.of().parseHex(vector.get("bytes").stringValue());
        byte[] packed = Arrays.copyOfRange(frame, Packed.LENGTH_BYTES, frame.length);
        if (vector.get("from").stringValue().equals("server")) {
            assertSame(written(Protocol.read(packed)), understood(vector.get("message")));
        } else {
            byte[] encoded = Packed.write(said(vector.get("message")));
            assertThat(ByteBuffer.wrap(encoded).getInt())
                    .isEqualTo(encoded.length - Packed.LENGTH_BYTES);
            assertSame(
                    Packed.read(Arrays.copyOfRange(encoded, Packed.LENGTH_BYTES, encoded.length)),
                    vector.get("message"));
        }
    }

    @Test
    void updatesAddUp() throws IOException {
        var messages =
                vectors("server.jsonl").map(message -> Protocol.read(message.toString())).toList();
        Perception perception =
                messages.stream()
                        .filter(Perception.class::isInstance)
                        .map(Perception.class::cast)
                        .filter(message -> message.id().equals(OptionalLong.of(2)))
                        .findFirst()
                        .orElseThrow();
        Perception first = perception;
        List<Update> updates =
                messages.stream().filter(Update.class::isInstance).map(Update.class::cast).toList();
        for (Update update : updates) {
            perception = perception.updated(update);
        }
        Perception.Item boat = perception.items().getFirst();
        assertThat(boat.location()).contains(new Perception.Location(3, 0, 0.5));
        assertThat(boat.orientation()).isEqualTo(Perception.Orientation.NONE);
        assertThat(boat.symbols()).containsEntry("class", "wreck");
        assertThat(boat.actions()).containsOnlyKeys("raise");
        assertThat(perception.find("duck").orElseThrow().actions()).isEmpty();
        assertThat(perception.find("shadow")).isEmpty();
        assertThatExceptionOfType(AgentException.class)
                .isThrownBy(() -> first.updated(updates.getLast()));
    }

    @Test
    void readingsStayUntilTheNextOnes() {
        var first =
                (Perception)
                        Protocol.read(
                                """
                                {"t":"perception","frame":5,"time":0.5,"items":[],"readings":{"imu":\
                                {"frame":4,"specificForce":[0,9.81,-1e-3],"angularVelocity":[0.5,0,0]}}}""");
        assertThat(first.readings().get("imu").numbers("specificForce"))
                .isEqualTo(DoubleBuffer.wrap(new double[] {0, 9.81, -1e-3}));
        var quiet =
                (Update)
                        Protocol.read(
                                """
                                {"t":"perception","frame":6,"time":0.6,"since":5}""");
        Perception second = first.updated(quiet);
        assertThat(second.readings()).isEqualTo(first.readings());
        var news =
                (Update)
                        Protocol.read(
                                """
                                {"t":"perception","frame":7,"time":0.7,"since":6,"readings":{"imu":\
                                {"frame":7,"specificForce":[1,2,3],"angularVelocity":[4,5,6]}}}""");
        Perception.Reading last = second.updated(news).readings().get("imu");
        assertThat(last.frame()).isEqualTo(7);
        assertThat(last.numbers("angularVelocity").get(2)).isEqualTo(6);
        assertThat(last.numbers("angularVelocity").isReadOnly()).isTrue();
        assertThatIllegalArgumentException()
                .isThrownBy(() -> last.numbers("distances"))
                .withMessage(
                        "the instrument does not measure distances; it measures"
                                + " [specificForce, angularVelocity]");
    }

    @Test
    void aRayThatMetNothingHasAnInfiniteDistance() {
        var perception =
                (Perception)
                        Protocol.read(
                                """
                                {"t":"perception","frame":5,"time":0.5,"items":[],"readings":{"scan":\
                                {"frame":5,"columns":2,"distances":[1.5,-1,0,7]}}}""");
        Perception.Reading scan = perception.readings().get("scan");
        assertThat(scan.numbers("distances"))
                .isEqualTo(DoubleBuffer.wrap(new double[] {1.5, Double.POSITIVE_INFINITY, 0, 7}));
        assertThat(scan.columns()).hasValue(2);
    }

    @ParameterizedTest
    @MethodSource("lenientServerMessages")
    void anUnusualFormMeansTheSame(JsonNode vector) {
        assertThat(Protocol.read(vector.get("line").stringValue()))
                .isEqualTo(Protocol.read(vector.get("means").toString()));
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "",
                "null",
                "[]",
                "{}",
                "{\"t\":1}",
                "{\"t\":\"jump\"}",
                "{\"t\":\"hello\"}",
                "{\"t\":\"result\",\"id\":1}",
                "{\"t\":\"event\",\"frame\":\"x\",\"type\":\"y\",\"fields\":{}}",
                "{\"t\":\"perception\",\"frame\":1,\"time\":0,\"items\":[{}]}",
                "{\"t\":\"bye\""
            })
    void whatIsNoMessageIsRefused(String line) {
        assertThatExceptionOfType(AgentException.class)
                .isThrownBy(() -> Protocol.read(line))
                .satisfies(e -> assertThat(e.code()).isEqualTo("protocol"))
                .withMessageContaining(line);
    }

    @Test
    void argumentsThatHaveNoFormAreRefusedBeforeTheyAreSent() {
        for (Object value :
                List.of(
                        Double.NaN,
                        List.of(1.0, Double.POSITIVE_INFINITY),
                        List.of("x"),
                        Map.of(),
                        new double[] {Double.NEGATIVE_INFINITY})) {
            assertThatIllegalArgumentException()
                    .isThrownBy(() -> Protocol.act(1, "duck", "push", Map.of("impulse", value)))
                    .withMessageContaining("argument impulse");
        }
    }

    /** Returns the message that this client writes for those values. */
    private static ObjectNode said(JsonNode message) {
        long id = message.path("id").asLong(0);
        return switch (message.get("t").stringValue()) {
            case "hello" ->
                    message.has("ask")
                            ? Protocol.ask(join(message), message.get("ask").stringValue())
                            : Protocol.hello(join(message));
            case "perceive" ->
                    message.has("every")
                            ? Protocol.perceive(id, message.get("every").intValue())
                            : message.has("relations")
                                    ? Protocol.perceiveWithRelations(id)
                                    : Protocol.perceive(id);
            case "act" -> {
                var arguments = new LinkedHashMap<String, Object>();
                message.get("arguments")
                        .properties()
                        .forEach(e -> arguments.put(e.getKey(), value(e.getValue())));
                ObjectNode act =
                        Protocol.act(
                                id,
                                message.get("item").stringValue(),
                                message.get("action").stringValue(),
                                arguments);
                yield message.has("ready") ? Protocol.andReady(act, frame(message)) : act;
            }
            case "look" -> {
                ObjectNode look = Protocol.look(id, message.get("sensor").stringValue());
                message.optional("item").ifPresent(item -> look.set("item", item));
                yield look;
            }
            case "ready" -> Protocol.ready(frame(message));
            case "ping" -> Protocol.ping(id);
            case "pong" -> Protocol.pong();
            case "bye" -> Protocol.bye();
            default -> {
                var fields = new LinkedHashMap<String, Object>();
                message.properties().stream()
                        .filter(field -> !List.of("t", "id").contains(field.getKey()))
                        .forEach(field -> fields.put(field.getKey(), value(field.getValue())));
                yield Protocol.command(id, message.get("t").stringValue(), fields);
            }
        };
    }

    private static OptionalLong frame(JsonNode message) {
        return message.has("frame")
                ? OptionalLong.of(message.get("frame").longValue())
                : OptionalLong.empty();
    }

    private static Join join(JsonNode hello) {
        Join join =
                Join.as(hello.get("name").stringValue())
                        .withRole(hello.path("role").asString("agent"))
                        .withGrace(Duration.ofSeconds(hello.path("graceSeconds").asInt(0)))
                        .withEncoding(hello.has("encoding") ? Encoding.MESSAGEPACK : Encoding.JSON);
        join = with(join, hello, "world", (all, world) -> all.withWorld(world.stringValue()));
        join = with(join, hello, "body", (all, body) -> all.withBody(body.stringValue()));
        join = with(join, hello, "time", (all, time) -> all.withLockStep(lockStep(time)));
        join =
                with(
                        join,
                        hello,
                        "resume",
                        (all, resume) ->
                                all.withResume(
                                        new Join.Resume(
                                                resume.get("session").stringValue(),
                                                resume.get("frame").longValue())));
        return with(join, hello, "token", (all, token) -> all.withToken(token.stringValue()));
    }

    private static LockStep lockStep(JsonNode time) {
        LockStep every =
                LockStep.every(time.path("every").asInt(1))
                        .withDeadline(
                                Duration.ofNanos((long) (1e9 * time.path("deadline").asDouble(1))));
        every = with(every, time, "relations", (all, relations) -> all.withRelations());
        return with(every, time, "fallback", (all, fallback) -> all.withFallback(act(fallback)));
    }

    private static Act act(JsonNode act) {
        var arguments = new LinkedHashMap<String, Object>();
        act.path("arguments")
                .properties()
                .forEach(e -> arguments.put(e.getKey(), value(e.getValue())));
        String action = act.get("action").stringValue();
        return act.has("item")
                ? Act.of(act.get("item").stringValue(), action, arguments)
                : Act.ofBody(action, arguments);
    }

    /** Returns the value changed by a field, if the message has the field. */
    private static <T> T with(
            T before, JsonNode message, String field, BiFunction<T, JsonNode, T> change) {
        return message.has(field) ? change.apply(before, message.get(field)) : before;
    }

    private static Object value(JsonNode value) {
        if (value.isArray()) {
            var elements = new ArrayList<Object>();
            value.forEach(each -> elements.add(each.isNumber() ? each.numberValue() : value(each)));
            return elements;
        }
        if (value.isObject()) {
            var values = new LinkedHashMap<String, Object>();
            value.properties()
                    .forEach(field -> values.put(field.getKey(), value(field.getValue())));
            return values;
        }
        if (value.isBoolean()) {
            return value.booleanValue();
        }
        return value.isNumber() ? value.numberValue() : value.stringValue();
    }

    /**
     * Returns the message that the server must have written for this client to read these values.
     */
    private static JsonNode written(ServerMessage message) {
        ObjectNode json = JSON.createObjectNode();
        switch (message) {
            case Welcome w -> {
                put(json.put("t", "welcome"), w.id());
                json.put("protocol", w.protocol()).put("role", w.role()).put("agent", w.agent());
                put(json, "body", w.body());
                json.put("world", w.world()).put("frame", w.frame()).put("rate", w.rate());
                if (!w.encoding().equals("json")) {
                    json.put("encoding", w.encoding());
                }
                w.lockStep()
                        .ifPresent(
                                time ->
                                        json.putObject("time")
                                                .put("mode", "lock-step")
                                                .put("every", time.every())
                                                .put("deadline", time.deadline().toNanos() / 1e9));
                w.session()
                        .ifPresent(
                                session -> {
                                    ObjectNode ticket = json.putObject("session");
                                    ticket.put("token", session.token());
                                    ticket.put("graceSeconds", session.graceSeconds());
                                    if (!session.servers().isEmpty()) {
                                        ticket.set("servers", JSON.valueToTree(session.servers()));
                                    }
                                });
                if (w.resumed()) {
                    json.put("resumed", true);
                }
                if (!w.cameras().isEmpty()) {
                    json.set("cameras", JSON.valueToTree(w.cameras()));
                }
                ObjectNode limits = json.putObject("limits");
                limits.put("lineBytes", w.limits().lineBytes())
                        .put("messagesPerSecond", w.limits().messagesPerSecond())
                        .put("actsInFlight", w.limits().actsInFlight())
                        .put("idleSeconds", w.limits().idleSeconds())
                        .put("graceSeconds", w.limits().graceSeconds());
                w.limits().items().ifPresent(most -> limits.put("items", most));
                w.limits().worldItems().ifPresent(most -> limits.put("worldItems", most));
                w.limits().eventBytes().ifPresent(most -> limits.put("eventBytes", most));
                w.limits().worldEventBytes().ifPresent(most -> limits.put("worldEventBytes", most));
            }
            case Perception p -> {
                put(json.put("t", "perception"), p.id());
                ArrayNode items =
                        json.put("frame", p.frame()).put("time", p.time()).putArray("items");
                p.items().forEach(item -> items.add(written(item)));
            }
            case Update u -> {
                put(json.put("t", "perception"), u.id());
                json.put("frame", u.frame()).put("time", u.time()).put("since", u.since());
                putIfAny(json, "left", u.left().stream().<JsonNode>map(JSON::valueToTree).toList());
                putIfAny(json, "entered", u.entered().stream().map(ProtocolTest::written).toList());
                putIfAny(json, "changed", u.changed().stream().map(ProtocolTest::written).toList());
            }
            case Image i -> {
                json.put("t", "image")
                        .put("id", i.id())
                        .put("frame", i.frame())
                        .put("time", i.time());
                json.put("sensor", i.sensor()).put("width", i.width()).put("height", i.height());
                i.colour().ifPresent(pixels -> json.put("colour", base64(pixels)));
                i.depth().ifPresent(pixels -> json.put("depth", base64(pixels)));
                i.items()
                        .ifPresent(
                                pixels ->
                                        json.put("items", base64(pixels))
                                                .set("names", JSON.valueToTree(i.names())));
            }
            case Report r ->
                    json.put("t", "report")
                            .put("id", r.id())
                            .put("frame", r.frame())
                            .put("of", r.of())
                            .set("content", JSON.valueToTree(r.content()));
            case ActResult r -> {
                json.put("t", "result").put("id", r.id()).put("accepted", r.accepted());
                r.frame().ifPresent(frame -> json.put("frame", frame));
                put(json, "code", r.code());
                put(json, "reason", r.reason());
                r.value().ifPresent(value -> json.set("value", JSON.valueToTree(value)));
            }
            case WorldEvent e ->
                    json.put("t", "event")
                            .put("frame", e.frame())
                            .put("type", e.type())
                            .set("fields", JSON.valueToTree(e.fields()));
            case ServerMessage.Error e -> {
                put(json.put("t", "error"), e.id());
                put(json.put("code", e.code()).put("message", e.message()), "hint", e.hint());
            }
            case ServerMessage.Ping p -> json.put("t", "ping");
            case ServerMessage.Pong p -> put(json.put("t", "pong"), p.id());
            case ServerMessage.Bye b -> {
                json.put("t", "bye").put("code", b.code()).put("message", b.message());
                put(json, "hint", b.hint());
                put(json, "address", b.address());
            }
        }
        return JSON.readTree(json.toString());
    }

    private static String base64(ByteBuffer bytes) {
        return StandardCharsets.ISO_8859_1
                .decode(Base64.getEncoder().encode(bytes.duplicate()))
                .toString();
    }

    private static void putIfAny(ObjectNode json, String field, List<JsonNode> values) {
        if (!values.isEmpty()) {
            json.set(field, JSON.valueToTree(values));
        }
    }

    /** Returns the item as JSON. An item without a field has the field's default. */
    private static JsonNode written(Perception.Item item) {
        ObjectNode json =
                (ObjectNode)
                        written(
                                new Update.Change(
                                        item.name(),
                                        item.location(),
                                        Optional.of(item.orientation())
                                                .filter(
                                                        turn ->
                                                                !turn.equals(
                                                                        Perception.Orientation
                                                                                .NONE)),
                                        Optional.of(item.symbols())
                                                .filter(symbols -> !symbols.isEmpty()),
                                        Optional.of(item.actions())
                                                .filter(actions -> !actions.isEmpty()),
                                        Optional.of(item.needs())
                                                .filter(needs -> !needs.isEmpty())));
        if (!item.capabilities().isEmpty()) {
            json.set("capabilities", JSON.valueToTree(item.capabilities()));
        }
        return json;
    }

    private static JsonNode written(Update.Change change) {
        ObjectNode json = JSON.createObjectNode().put("name", change.name());
        change.location()
                .ifPresent(at -> json.putArray("location").add(at.x()).add(at.y()).add(at.z()));
        change.orientation()
                .ifPresent(
                        turn ->
                                json.putArray("orientation")
                                        .add(turn.x())
                                        .add(turn.y())
                                        .add(turn.z())
                                        .add(turn.w()));
        change.symbols().ifPresent(symbols -> json.set("symbols", JSON.valueToTree(symbols)));
        change.needs().ifPresent(needs -> json.set("needs", JSON.valueToTree(needs)));
        change.actions()
                .ifPresent(
                        all -> {
                            ObjectNode actions = json.putObject("actions");
                            all.forEach(
                                    (action, parameters) -> {
                                        ObjectNode one = actions.putObject(action);
                                        parameters.forEach(
                                                (name, parameter) -> {
                                                    ObjectNode fields =
                                                            one.putObject(name)
                                                                    .put("type", parameter.type());
                                                    parameter
                                                            .components()
                                                            .ifPresent(
                                                                    count ->
                                                                            fields.put(
                                                                                    "components",
                                                                                    count));
                                                    put(fields, "unit", parameter.unit());
                                                    parameter
                                                            .min()
                                                            .ifPresent(
                                                                    bound ->
                                                                            fields.put(
                                                                                    "min", bound));
                                                    parameter
                                                            .max()
                                                            .ifPresent(
                                                                    bound ->
                                                                            fields.put(
                                                                                    "max", bound));
                                                });
                                    });
                        });
        return json;
    }

    /** Returns a message of the server without the fields whose values are defaults. */
    private static JsonNode understood(JsonNode message) {
        for (String list : List.of("items", "entered")) {
            message.path(list)
                    .forEach(
                            item -> {
                                for (String field : List.of("symbols", "actions")) {
                                    if (item.path(field).isEmpty()) {
                                        item.asObject().remove(field);
                                    }
                                }
                            });
        }
        return message;
    }

    private static void put(ObjectNode json, OptionalLong id) {
        id.ifPresent(number -> json.put("id", number));
    }

    private static void put(ObjectNode json, String field, Optional<String> text) {
        text.ifPresent(value -> json.put(field, value));
    }

    private static void assertSame(JsonNode actual, JsonNode expected) {
        assertThat(actual.equals(ProtocolTest::compareLeaves, expected))
                .as("expected %s%n but was %s", expected, actual)
                .isTrue();
    }

    private static int compareLeaves(JsonNode a, JsonNode b) {
        if (a.isNumber() && b.isNumber()) {
            return Double.compare(a.doubleValue(), b.doubleValue());
        }
        return a.equals(b) ? 0 : 1;
    }

    private static Stream<JsonNode> vectors(String file) throws IOException {
        String root =
                Objects.requireNonNull(
                        System.getProperty("reve.root"),
                        "set -Dreve.root to the folder of the project");
        return Files.readAllLines(Path.of(root, "agents/protocol/vectors", file)).stream()
                .map(JSON::readTree);
    }
}
