package reve.core.agent;

import java.io.ByteArrayOutputStream;
import java.util.Map;
import java.util.Optional;
import tools.jackson.core.JsonGenerator;

/** What the server says, but for perceptions. {@code id} is {@link ClientMessage#NO_ID} where it answers none. */
sealed interface ServerMessage {

    /** The id of the message that this answers. */
    default long id() {
        return ClientMessage.NO_ID;
    }

    record Limits(int lineBytes, int actsInFlight, double idleSeconds, double graceSeconds) {}

    /** With it, another connection goes on with the session within that time after the first broke. */
    record Ticket(String token, double graceSeconds) {}

    /** @param body of a client of the role agent */
    record Welcome(long id, int protocol, Role role, String agent, Optional<String> body, String world, long frame,
            int rate, Optional<Ticket> session, boolean resumed, Limits limits) implements ServerMessage {}

    record Accepted(long id, long frame) implements ServerMessage {}

    record Refused(long id, String code, String reason) implements ServerMessage {}

    /** @param fields String, Number or Boolean by name */
    record Event(long frame, String type, Map<String, Object> fields) implements ServerMessage {}

    record Error(long id, String code, String message, String hint) implements ServerMessage {}

    record Ping() implements ServerMessage {}

    record Pong(long id) implements ServerMessage {}

    record Bye(String code, String message, Optional<String> hint) implements ServerMessage {}

    /** The line that says it, with its end. */
    default byte[] line() {
        var bytes = new ByteArrayOutputStream(256);
        try (JsonGenerator json = Json.MAPPER.createGenerator(bytes)) {
            json.writeStartObject();
            json.writeStringProperty("t", type(this));
            if (id() != ClientMessage.NO_ID) {
                json.writeNumberProperty("id", id());
            }
            writeFields(this, json);
            json.writeEndObject();
        }
        bytes.write('\n');
        return bytes.toByteArray();
    }

    private static String type(ServerMessage message) {
        return switch (message) {
            case Welcome welcome -> "welcome";
            case Accepted accepted -> "result";
            case Refused refused -> "result";
            case Event event -> "event";
            case Error error -> "error";
            case Ping ping -> "ping";
            case Pong pong -> "pong";
            case Bye bye -> "bye";
        };
    }

    private static void writeFields(ServerMessage message, JsonGenerator json) {
        switch (message) {
            case Welcome welcome -> writeWelcome(welcome, json);
            case Accepted accepted -> {
                json.writeBooleanProperty("accepted", true);
                json.writeNumberProperty("frame", accepted.frame);
            }
            case Refused refused -> {
                json.writeBooleanProperty("accepted", false);
                json.writeStringProperty("code", refused.code);
                json.writeStringProperty("reason", refused.reason);
            }
            case Event event -> {
                json.writeNumberProperty("frame", event.frame);
                json.writeStringProperty("type", event.type);
                json.writeObjectPropertyStart("fields");
                event.fields.forEach((name, value) -> {
                    json.writeName(name);
                    Json.writeValue(json, value);
                });
                json.writeEndObject();
            }
            case Error error -> {
                json.writeStringProperty("code", error.code);
                json.writeStringProperty("message", error.message);
                json.writeStringProperty("hint", error.hint);
            }
            case Bye bye -> {
                json.writeStringProperty("code", bye.code);
                json.writeStringProperty("message", bye.message);
                bye.hint.ifPresent(hint -> json.writeStringProperty("hint", hint));
            }
            case Ping ping -> { }
            case Pong pong -> { }
        }
    }

    private static void writeWelcome(Welcome welcome, JsonGenerator json) {
        json.writeNumberProperty("protocol", welcome.protocol);
        json.writeStringProperty("role", welcome.role.wireName());
        json.writeStringProperty("agent", welcome.agent);
        welcome.body.ifPresent(body -> json.writeStringProperty("body", body));
        json.writeStringProperty("world", welcome.world);
        json.writeNumberProperty("frame", welcome.frame);
        json.writeNumberProperty("rate", welcome.rate);
        welcome.session.ifPresent(session -> {
            json.writeObjectPropertyStart("session");
            json.writeStringProperty("token", session.token);
            json.writeNumberProperty("graceSeconds", session.graceSeconds);
            json.writeEndObject();
        });
        if (welcome.resumed) {
            json.writeBooleanProperty("resumed", true);
        }
        json.writeObjectPropertyStart("limits");
        json.writeNumberProperty("lineBytes", welcome.limits.lineBytes);
        json.writeNumberProperty("actsInFlight", welcome.limits.actsInFlight);
        json.writeNumberProperty("idleSeconds", welcome.limits.idleSeconds);
        json.writeNumberProperty("graceSeconds", welcome.limits.graceSeconds);
        json.writeEndObject();
    }
}
