// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import org.jspecify.annotations.Nullable;

import reve.core.agent.embodiment.Embodiment;
import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.FinishedCommand;
import reve.core.agent.protocol.ActionRequest;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Json;
import reve.core.agent.protocol.MessageReader;
import reve.core.agent.protocol.Role;
import reve.core.agent.protocol.ServerMessage;
import reve.core.agent.protocol.Text;
import reve.core.world.ItemId;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.ObjectNode;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.OptionalLong;

/**
 * A session as one server writes it and another one reads it. Results other than those of acts are
 * not included, and only the newest events: at most {@value #MAX_EVENT_CHARACTERS} characters.
 *
 * @param secretSha256 hash of the session's token
 * @param hello the hello of the session, without secrets
 * @param tokenSha256 hash of the client's token; empty if the server uses no tokens
 * @param network network address of the client, as for limits by address
 * @param body the client's body, if it has one
 * @param brokenSeconds time since the client's connection broke; 0 if it did not break
 * @param resultFrame newest frame in which a command of the client took effect
 * @param results results of the client's commands, oldest first
 * @param forgottenId highest id of a command whose result is not included
 * @param events recent events for the client, in order
 * @param forgottenFrame newest frame of which some events are not included
 */
record SessionState(
        String secretSha256,
        Role role,
        ClientMessage.Hello hello,
        Optional<String> tokenSha256,
        byte[] network,
        Optional<Embodiment.Granted> body,
        double brokenSeconds,
        long resultFrame,
        List<ServerMessage> results,
        long forgottenId,
        List<ServerMessage.Event> events,
        long forgottenFrame) {

    private static final int MAX_EVENT_CHARACTERS = 65_536;

    /** Writes the state. */
    CarriedSession write() {
        ObjectNode json = Json.MAPPER.createObjectNode();
        json.put("secretSha256", secretSha256);
        json.put("role", role.wireName());
        json.put("id", hello.id());
        json.put("name", hello.name());
        hello.world().ifPresent(world -> json.put("world", world));
        json.put("encoding", hello.encoding());
        json.put("graceSeconds", hello.graceSeconds());
        hello.lockStep().ifPresent(time -> write(json.putObject("time"), time));
        tokenSha256.ifPresent(token -> json.put("tokenSha256", token));
        json.put("network", network);
        body.ifPresent(
                granted -> {
                    ObjectNode item = json.putObject("body");
                    item.put("item", granted.id().value());
                    granted.place().ifPresent(place -> item.put("place", place));
                });
        json.put("brokenSeconds", brokenSeconds);
        json.put("resultFrame", resultFrame);
        long forgotten = forgottenId;
        ArrayNode done = json.putArray("results");
        for (ServerMessage result : results) {
            switch (result) {
                case ServerMessage.Accepted accepted ->
                        done.addObject().put("id", accepted.id()).put("frame", accepted.frame());
                case ServerMessage.Refused refused ->
                        done.addObject()
                                .put("id", refused.id())
                                .put("code", refused.code())
                                .put("reason", refused.reason());
                case ServerMessage.Answer answer -> forgotten = Math.max(forgotten, answer.id());
                default -> {}
            }
        }
        json.put("forgottenId", forgotten);
        writeEvents(json);
        return new CarriedSession(
                hello.name(),
                body.map(granted -> OptionalLong.of(granted.id().value()))
                        .orElse(OptionalLong.empty()),
                json.toString());
    }

    private void writeEvents(ObjectNode json) {
        List<ObjectNode> newest = new ArrayList<>();
        long forgotten = forgottenFrame;
        int characters = 0;
        for (ServerMessage.Event event : events.reversed()) {
            ObjectNode written = Json.MAPPER.createObjectNode();
            written.put("frame", event.frame());
            written.put("type", event.type());
            written.set("fields", Json.MAPPER.valueToTree(event.fields()));
            characters += written.toString().length();
            if (characters > MAX_EVENT_CHARACTERS) {
                forgotten = Math.max(forgotten, event.frame());
                break;
            }
            newest.addFirst(written);
        }
        json.put("forgottenFrame", forgotten);
        ArrayNode list = json.putArray("events");
        newest.forEach(list::add);
    }

    private static void write(ObjectNode json, ClientMessage.LockStep time) {
        json.put("every", time.every());
        json.put("relations", time.relations());
        json.put("deadline", time.deadlineSeconds());
        time.fallback()
                .ifPresent(
                        action -> {
                            ObjectNode fallback = json.putObject("fallback");
                            action.item().ifPresent(item -> fallback.put("item", item));
                            fallback.put("action", action.action());
                            fallback.set("arguments", Json.MAPPER.valueToTree(action.arguments()));
                        });
    }

    /**
     * Reads a state.
     *
     * @param lastFrame last frame of the world; the events until then are missing if the server of
     *     the session was lost
     * @throws IllegalArgumentException if it is not complete, for example because a server of
     *     another version wrote it
     */
    static SessionState read(CarriedSession carried, long lastFrame) {
        try {
            JsonNode json = Json.MAPPER.readTree(carried.state());
            Role role =
                    Role.of(json.required("role").stringValue())
                            .orElseThrow(() -> new IllegalArgumentException("unknown role"));
            List<ServerMessage> results = new ArrayList<>();
            for (JsonNode result : json.required("results")) {
                long id = result.required("id").longValue();
                results.add(
                        result.has("frame")
                                ? new ServerMessage.Accepted(id, result.get("frame").longValue())
                                : new ServerMessage.Refused(
                                        id,
                                        result.required("code").stringValue(),
                                        result.required("reason").stringValue()));
            }
            long resultFrame = json.required("resultFrame").longValue();
            long forgottenId = json.required("forgottenId").longValue();
            long forgottenFrame = json.required("forgottenFrame").longValue();
            if (carried.since().isPresent()) {
                CarriedSession.Since since = carried.since().get();
                for (FinishedCommand command : since.finished()) {
                    resultFrame = Math.max(resultFrame, command.frame());
                    results.add(
                            command.isAccepted()
                                    ? new ServerMessage.Accepted(command.id(), command.frame())
                                    : new ServerMessage.Refused(
                                            command.id(), command.code(), command.reason()));
                }
                forgottenId = Math.max(forgottenId, since.forgottenId());
                forgottenFrame = Math.max(forgottenFrame, lastFrame);
            }
            List<ServerMessage.Event> events = new ArrayList<>();
            for (JsonNode event : json.required("events")) {
                events.add(
                        new ServerMessage.Event(
                                event.required("frame").longValue(),
                                event.required("type").stringValue(),
                                values(event.required("fields"))));
            }
            JsonNode body = json.get("body");
            return new SessionState(
                    json.required("secretSha256").stringValue(),
                    role,
                    hello(json, role),
                    text(json, "tokenSha256"),
                    json.required("network").binaryValue(),
                    body == null
                            ? Optional.empty()
                            : Optional.of(
                                    new Embodiment.Granted(
                                            new ItemId(body.required("item").longValue()),
                                            body.has("place")
                                                    ? OptionalInt.of(body.get("place").intValue())
                                                    : OptionalInt.empty())),
                    json.path("brokenSeconds").doubleValue(0),
                    resultFrame,
                    results,
                    forgottenId,
                    events,
                    forgottenFrame);
        } catch (JacksonException | IllegalArgumentException wrong) {
            throw new IllegalArgumentException(
                    "the session of "
                            + Text.quote(carried.client())
                            + " is damaged, or was written by another version: "
                            + (wrong instanceof JacksonException json
                                    ? json.getOriginalMessage()
                                    : wrong.getMessage()),
                    wrong);
        }
    }

    private static ClientMessage.Hello hello(JsonNode json, Role role) {
        JsonNode time = json.get("time");
        return new ClientMessage.Hello(
                json.required("id").longValue(),
                ClientMessage.PROTOCOL,
                json.required("name").stringValue(),
                role.wireName(),
                text(json, "world"),
                Optional.empty(),
                encoding(json),
                within(json, "graceSeconds", 0, MessageReader.MAX_SECONDS),
                time == null ? Optional.empty() : Optional.of(lockStep(time)),
                Optional.empty(),
                Optional.empty(),
                Optional.empty());
    }

    private static ClientMessage.LockStep lockStep(JsonNode time) {
        JsonNode fallback = time.get("fallback");
        return new ClientMessage.LockStep(
                (int) within(time, "every", 1, MessageReader.MAX_EVERY),
                time.required("relations").booleanValue(),
                within(time, "deadline", 0, MessageReader.MAX_SECONDS),
                fallback == null
                        ? Optional.empty()
                        : Optional.of(
                                new ActionRequest(
                                        text(fallback, "item"),
                                        fallback.required("action").stringValue(),
                                        values(fallback.required("arguments")))));
    }

    /** Returns a number, which has the limits of a client's {@code hello}. */
    private static double within(JsonNode json, String field, double min, double max) {
        double value = json.required(field).doubleValue();
        if (!(value >= min && value <= max)) {
            throw new IllegalArgumentException(
                    field + " is " + value + ", expected " + min + " to " + max);
        }
        return value;
    }

    private static String encoding(JsonNode json) {
        String name = json.required("encoding").stringValue();
        return Encoding.of(name)
                .map(_ -> name)
                .orElseThrow(() -> new IllegalArgumentException("unknown encoding"));
    }

    private static Optional<String> text(JsonNode json, String field) {
        @Nullable JsonNode value = json.get(field);
        return value == null ? Optional.empty() : Optional.of(value.stringValue());
    }

    private static Map<String, Object> values(JsonNode json) {
        Map<String, Object> values = new LinkedHashMap<>();
        json.forEachEntry(
                (name, value) -> values.put(name, Json.MAPPER.treeToValue(value, Object.class)));
        return values;
    }
}
