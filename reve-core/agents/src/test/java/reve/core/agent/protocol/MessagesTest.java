// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.MethodSource;

import reve.core.agent.port.Cameras;

import tools.jackson.core.type.TypeReference;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ObjectNode;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.Base64;
import java.util.HexFormat;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;
import java.util.stream.Stream;

/** The protocol's test vectors, message by message. */
class MessagesTest {

    private static final JsonMapper JSON = new JsonMapper();

    static Stream<JsonNode> clientMessages() {
        return Vectors.lines("client.jsonl").stream();
    }

    static Stream<JsonNode> lenientClientMessages() {
        return Vectors.lines("lenient.jsonl").stream()
                .filter(vector -> vector.get("from").stringValue().equals("client"));
    }

    static Stream<JsonNode> serverMessages() {
        return Vectors.lines("server.jsonl").stream()
                .filter(message -> !message.get("t").stringValue().equals("perception"));
    }

    static Stream<JsonNode> refusedLines() {
        return Vectors.lines("refused.jsonl").stream()
                .filter(vector -> !vector.get("code").stringValue().equals("hello-again"));
    }

    @ParameterizedTest
    @MethodSource("clientMessages")
    void aClientsMessageIsUnderstood(JsonNode message) throws BadMessage {
        Vectors.assertSame(written(read(message.toString())), message);
    }

    @ParameterizedTest
    @MethodSource("lenientClientMessages")
    void anUnusualFormMeansTheSame(JsonNode vector) throws BadMessage {
        ClientMessage message = read(vector.get("line").stringValue());
        assertThat(message).isEqualTo(read(vector.get("means").toString()));
        Vectors.assertSame(written(message), vector.get("means"));
    }

    @ParameterizedTest
    @MethodSource("refusedLines")
    void aBadLineIsRefusedWithItsCode(JsonNode vector) {
        byte[] line =
                vector.has("bytes")
                        ? HexFormat.of().parseHex(vector.get("bytes").stringValue())
                        : vector.get("line").stringValue().getBytes(StandardCharsets.UTF_8);
        assertThatThrownBy(() -> MessageReader.read(ByteBuffer.wrap(line), Encoding.JSON))
                .isInstanceOfSatisfying(
                        BadMessage.class,
                        e -> {
                            assertThat(e.error().code())
                                    .isEqualTo(vector.get("code").stringValue());
                            assertThat(e.error().message()).isNotBlank();
                            assertThat(e.error().hint()).isNotBlank();
                        });
    }

    @ParameterizedTest
    @MethodSource("packedMessages")
    void aPackedMessageOfAClientMeansTheSame(JsonNode vector) throws BadMessage {
        byte[] frame = bytes(vector);
        ByteBuffer packed =
                ByteBuffer.wrap(frame, Encoding.LENGTH_BYTES, frame.length - Encoding.LENGTH_BYTES);
        assertThat(ByteBuffer.wrap(frame).getInt()).isEqualTo(packed.remaining());
        assertThat(MessageReader.read(packed.slice(), Encoding.MESSAGEPACK))
                .isEqualTo(read(vector.get("message").toString()));
    }

    @ParameterizedTest
    @MethodSource("packedRefused")
    void aBadPackedMessageIsRefusedWithItsCode(JsonNode vector) {
        byte[] frame = bytes(vector);
        ByteBuffer packed =
                ByteBuffer.wrap(frame, Encoding.LENGTH_BYTES, frame.length - Encoding.LENGTH_BYTES);
        assertThatThrownBy(() -> MessageReader.read(packed.slice(), Encoding.MESSAGEPACK))
                .isInstanceOfSatisfying(
                        BadMessage.class,
                        e ->
                                assertThat(e.error().code())
                                        .isEqualTo(vector.get("code").stringValue()));
    }

    @ParameterizedTest
    @MethodSource("serverMessages")
    void aServersMessageIsPackedWithTheSameFields(JsonNode message) {
        ByteBuffer frame = ByteBuffer.wrap(message(message).in(Encoding.MESSAGEPACK));
        assertThat(frame.getInt()).isEqualTo(frame.remaining());
        Vectors.assertSame(
                MessagePackReader.read(frame.slice(), Base64.getEncoder()::encodeToString),
                message);
    }

    static Stream<JsonNode> packedMessages() {
        return Vectors.lines("packed.jsonl").stream()
                .filter(vector -> vector.get("from").stringValue().equals("client"));
    }

    static Stream<JsonNode> packedRefused() {
        return Vectors.lines("packed-refused.jsonl").stream();
    }

    private static byte[] bytes(JsonNode vector) {
        return HexFormat.of().parseHex(vector.get("bytes").stringValue());
    }

    @Test
    void aLengthThatNoMessageHasIsNamed() {
        assertUnreadable("81a174dbffffffff", "a length is 4294967295, which is too large");
        assertUnreadable("81a174db0000", "the message ends within a value");
    }

    private static void assertUnreadable(String bytes, String reason) {
        ByteBuffer message = ByteBuffer.wrap(HexFormat.of().parseHex(bytes));
        assertThatThrownBy(() -> MessageReader.read(message, Encoding.MESSAGEPACK))
                .isInstanceOfSatisfying(
                        BadMessage.class,
                        e ->
                                assertThat(e.error().message())
                                        .isEqualTo("this is no MessagePack: " + reason));
    }

    @Test
    void aBadFieldIsNamedWithWhatWasFoundAndExpectedAndTheIdIsKept() {
        assertThatThrownBy(() -> read("{\"t\":\"perceive\",\"id\":12,\"every\":\"often\"}"))
                .isInstanceOfSatisfying(
                        BadMessage.class,
                        e ->
                                assertThat(e.error())
                                        .isEqualTo(
                                                new ServerMessage.Error(
                                                        12,
                                                        "bad-field",
                                                        "the field every is \"often\"",
                                                        "expected an integer from 0 to 1000000")));
    }

    @ParameterizedTest
    @MethodSource("serverMessages")
    void aServersMessageIsWrittenAsDocumented(JsonNode message) {
        byte[] line = message(message).in(Encoding.JSON);
        assertThat(line).endsWith('\n').containsOnlyOnce('\n');
        Vectors.assertSame(JSON.readTree(line), message);
    }

    @Test
    void whatIsNotFiniteInAnEventLeavesTheLineValid() {
        byte[] line =
                new ServerMessage.Event(1, "fault", Map.of("value", Double.NaN)).in(Encoding.JSON);
        assertThat(JSON.readTree(line).at("/fields/value").stringValue()).isEqualTo("NaN");
    }

    @Test
    void foreignTextIsShownWithoutControlAndFormatCharacters() {
        assertThat(Text.quote("duck")).isEqualTo("\"duck\"");
        assertThat(Text.quote("a\n\u0000\u202e\"\\é🦆"))
                .isEqualTo("\"a\\u{a}\\u{0}\\u{202e}\\\"\\\\é🦆\"");
        assertThat(Text.quote("x".repeat(100))).isEqualTo("\"" + "x".repeat(64) + "…\"");
        assertThat(Text.quote("\ud83e")).isEqualTo("\"\\u{d83e}\"");
    }

    private static ClientMessage read(String line) throws BadMessage {
        return MessageReader.read(
                ByteBuffer.wrap(line.getBytes(StandardCharsets.UTF_8)), Encoding.JSON);
    }

    /** Returns the message as a client would write it. */
    private static JsonNode written(ClientMessage message) {
        ObjectNode json = JSON.createObjectNode();
        json.put("t", message.type());
        if (message.id() != ClientMessage.NO_ID) {
            json.put("id", message.id());
        }
        switch (message) {
            case ClientMessage.Hello hello -> {
                json.put("protocol", hello.protocol()).put("name", hello.name());
                if (!hello.role().equals("agent")) {
                    json.put("role", hello.role());
                }
                hello.world().ifPresent(world -> json.put("world", world));
                hello.body().ifPresent(body -> json.put("body", body));
                if (!hello.encoding().equals("json")) {
                    json.put("encoding", hello.encoding());
                }
                if (hello.graceSeconds() > 0) {
                    json.put("graceSeconds", hello.graceSeconds());
                }
                hello.lockStep().ifPresent(lockStep -> putTime(json.putObject("time"), lockStep));
                hello.resume()
                        .ifPresent(
                                resume ->
                                        json.putObject("resume")
                                                .put("session", resume.session())
                                                .put("frame", resume.frame()));
                hello.token().ifPresent(token -> json.put("token", token));
                hello.ask().ifPresent(question -> json.put("ask", question));
            }
            case ClientMessage.Perceive perceive -> {
                if (perceive.every() != ClientMessage.Perceive.ONCE) {
                    json.put("every", perceive.every());
                }
                if (perceive.relations()) {
                    json.put("relations", true);
                }
            }
            case ClientMessage.Act act -> {
                put(json, act.requested());
                act.ready()
                        .ifPresent(
                                ready -> {
                                    json.put("ready", true);
                                    ready.frame().ifPresent(frame -> json.put("frame", frame));
                                });
            }
            case ClientMessage.Look look -> {
                json.put("sensor", look.sensor());
                look.item().ifPresent(item -> json.put("item", item));
            }
            case ClientMessage.Ready ready ->
                    ready.frame().ifPresent(frame -> json.put("frame", frame));
            case ClientMessage.Step step -> json.put("frames", step.frames());
            case ClientMessage.LoadLaw load -> {
                json.put("library", load.library())
                        .set("parameters", JSON.valueToTree(load.parameters()));
                load.text().ifPresent(text -> json.put("text", text));
                load.swap().ifPresent(swap -> json.put("swap", swap.text()));
            }
            case ClientMessage.UnloadLaw unload -> json.put("library", unload.library());
            case ClientMessage.Edit edit ->
                    json.put("item", edit.item())
                            .put("property", edit.property())
                            .set("value", JSON.valueToTree(edit.value()));
            case ClientMessage.Add add -> json.setAll((ObjectNode) JSON.readTree(add.items()));
            case ClientMessage.Change change ->
                    json.put("item", change.item()).set("to", JSON.readTree(change.to()));
            case ClientMessage.Remove remove -> {
                json.put("item", remove.item());
                if (remove.cascade()) {
                    json.put("cascade", true);
                }
            }
            case ClientMessage.SetRule rule -> {
                json.put("name", rule.name());
                rule.rule().ifPresent(text -> json.set("rule", JSON.readTree(text)));
            }
            case ClientMessage.Batch batch ->
                    batch.changes()
                            .forEach(change -> json.withArray("changes").add(written(change)));
            case ClientMessage.Snapshot snapshot -> json.put("image", snapshot.image());
            case ClientMessage.Rewind rewind ->
                    rewind.image().ifPresent(image -> json.put("image", image));
            case ClientMessage.Save save -> json.put("file", save.file());
            case ClientMessage.Speed speed -> json.put("factor", speed.factor());
            case ClientMessage.SetLaw set -> {
                json.put("library", set.library())
                        .set("parameters", JSON.valueToTree(set.parameters()));
                set.swap().ifPresent(swap -> json.put("swap", swap.text()));
            }
            case ClientMessage.SetBudget set -> {
                json.put("library", set.library());
                set.budget()
                        .ifPresent(
                                budget ->
                                        json.setAll(
                                                (ObjectNode) JSON.valueToTree(budget.fields())));
            }
            case ClientMessage.Ledger ledger ->
                    ledger.open().ifPresent(open -> json.put("open", open));
            case ClientMessage.Audit audit -> {
                audit.client().ifPresent(client -> json.put("client", client));
                if (audit.frequent()) {
                    json.put("frequent", true);
                }
                if (audit.most() != ClientMessage.Audit.DEFAULT) {
                    json.put("most", audit.most());
                }
            }
            case ClientMessage.Inspect inspect -> json.put("item", inspect.item());
            case ClientMessage.State state -> {
                if (state.roundTrips()) {
                    json.put("roundTrips", true);
                }
            }
            case ClientMessage.Laws laws -> {}
            case ClientMessage.Search search -> json.put("text", search.text());
            case ClientMessage.Perceived perceived -> json.put("client", perceived.client());
            case ClientMessage.Fork fork -> {
                json.put("frames", fork.frames());
                fork.changes()
                        .ifPresent(batch -> json.set("changes", written(batch).get("changes")));
            }
            case ClientMessage.Ask ask ->
                    ask.arguments()
                            .forEach((name, value) -> json.set(name, JSON.valueToTree(value)));
            case ClientMessage.MoveWorld move ->
                    json.put("world", move.world()).put("node", move.node());
            case ClientMessage.DrainNode drain -> {
                json.put("node", drain.node());
                if (!drain.drained()) {
                    json.put("drained", false);
                }
            }
            case ClientMessage.AddWorld add -> {
                json.put("text", add.text());
                if (add.asleep()) {
                    json.put("asleep", true);
                }
            }
            case ClientMessage.Release release -> json.put("library", release.library());
            case ClientMessage.Pause pause -> {}
            case ClientMessage.Run run -> {}
            case ClientMessage.Picture picture -> {}
            case ClientMessage.ShutDown shutDown -> {}
            case ClientMessage.Ping ping -> {}
            case ClientMessage.Pong pong -> {}
            case ClientMessage.Bye bye -> {}
        }
        return JSON.readTree(json.toString());
    }

    private static void putTime(ObjectNode json, ClientMessage.LockStep time) {
        json.put("mode", "lock-step");
        if (time.every() != 1) {
            json.put("every", time.every());
        }
        if (time.relations()) {
            json.put("relations", true);
        }
        if (time.deadlineSeconds() != 1) {
            json.put("deadline", time.deadlineSeconds());
        }
        time.fallback().ifPresent(fallback -> put(json.putObject("fallback"), fallback));
    }

    private static void put(ObjectNode json, ActionRequest requested) {
        requested.item().ifPresent(item -> json.put("item", item));
        json.put("action", requested.action())
                .set("arguments", JSON.valueToTree(requested.arguments()));
    }

    /** Returns the server's message with those values. */
    private static ServerMessage message(JsonNode json) {
        long id = json.path("id").asLong(ClientMessage.NO_ID);
        return switch (json.get("t").stringValue()) {
            case "welcome" ->
                    new ServerMessage.Welcome(
                            id,
                            json.get("protocol").intValue(),
                            Role.of(text(json, "role")).orElseThrow(),
                            text(json, "agent"),
                            json.optional("body").map(JsonNode::stringValue),
                            text(json, "world"),
                            json.get("frame").longValue(),
                            json.get("rate").intValue(),
                            Encoding.of(json.path("encoding").asString("json")).orElseThrow(),
                            json.optional("time")
                                    .map(
                                            time ->
                                                    new ServerMessage.Rhythm(
                                                            time.get("every").intValue(),
                                                            time.get("deadline").doubleValue())),
                            json.optional("session")
                                    .map(
                                            session ->
                                                    new ServerMessage.Ticket(
                                                            text(session, "token"),
                                                            session.get("graceSeconds")
                                                                    .doubleValue(),
                                                            session.path("servers")
                                                                    .valueStream()
                                                                    .map(JsonNode::stringValue)
                                                                    .toList())),
                            json.has("resumed"),
                            new ServerMessage.Limits(
                                    json.at("/limits/lineBytes").intValue(),
                                    json.at("/limits/messagesPerSecond").intValue(),
                                    json.at("/limits/actsInFlight").intValue(),
                                    json.at("/limits/idleSeconds").doubleValue(),
                                    json.at("/limits/graceSeconds").doubleValue(),
                                    json.at("/limits/items").intValue(),
                                    json.at("/limits/worldItems").intValue(),
                                    json.at("/limits/eventBytes").intValue(),
                                    json.at("/limits/worldEventBytes").intValue()),
                            json.path("cameras").valueStream().map(JsonNode::stringValue).toList());
            case "result" ->
                    json.get("accepted").booleanValue()
                            ? json.has("value")
                                    ? new ServerMessage.Answer(
                                            id,
                                            json.get("frame").longValue(),
                                            JSON.treeToValue(json.get("value"), Object.class))
                                    : new ServerMessage.Accepted(id, json.get("frame").longValue())
                            : new ServerMessage.Refused(
                                    id, text(json, "code"), text(json, "reason"));
            case "report" ->
                    new ServerMessage.Report(
                            id,
                            json.get("frame").longValue(),
                            text(json, "of"),
                            JSON.convertValue(
                                    json.get("content"),
                                    new TypeReference<Map<String, Object>>() {}));
            case "image" ->
                    new ServerMessage.Image(
                            id,
                            text(json, "sensor"),
                            new Cameras.Photo(
                                    json.get("frame").longValue(),
                                    json.get("time").doubleValue(),
                                    json.get("width").intValue(),
                                    json.get("height").intValue(),
                                    pixels(json, "colour"),
                                    pixels(json, "depth"),
                                    pixels(json, "items"),
                                    json.path("names")
                                            .valueStream()
                                            .map(JsonNode::stringValue)
                                            .toList()));
            case "event" -> {
                var fields = new LinkedHashMap<String, Object>();
                json.get("fields")
                        .properties()
                        .forEach(field -> fields.put(field.getKey(), value(field.getValue())));
                yield new ServerMessage.Event(
                        json.get("frame").longValue(), text(json, "type"), fields);
            }
            case "error" ->
                    new ServerMessage.Error(
                            id, text(json, "code"), text(json, "message"), text(json, "hint"));
            case "ping" -> new ServerMessage.Ping();
            case "pong" -> new ServerMessage.Pong(id);
            case "bye" ->
                    new ServerMessage.Bye(
                            text(json, "code"),
                            text(json, "message"),
                            json.optional("hint").map(JsonNode::stringValue),
                            json.optional("address").map(JsonNode::stringValue));
            default -> throw new AssertionError("no such message: " + json);
        };
    }

    private static Optional<byte[]> pixels(JsonNode json, String layer) {
        return json.optional(layer).map(text -> Base64.getDecoder().decode(text.stringValue()));
    }

    private static Object value(JsonNode value) {
        if (value.isString()) {
            return value.stringValue();
        }
        if (value.isArray()) {
            return value.valueStream().map(MessagesTest::value).toList();
        }
        return value.isBoolean() ? (Object) value.booleanValue() : value.numberValue();
    }

    private static String text(JsonNode json, String field) {
        return json.get(field).stringValue();
    }
}
