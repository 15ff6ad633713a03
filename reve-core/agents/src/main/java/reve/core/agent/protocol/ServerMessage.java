// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import reve.core.agent.port.Cameras;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;

/**
 * A message from the server, except perceptions. A message that answers no message of the client
 * has the id {@link ClientMessage#NO_ID}.
 */
public sealed interface ServerMessage {

    /** Returns the id of the answered message. */
    default long id() {
        return ClientMessage.NO_ID;
    }

    /** The limits that the welcome states to the client. */
    record Limits(
            int lineBytes,
            int messagesPerSecond,
            int actsInFlight,
            double idleSeconds,
            double graceSeconds,
            int items,
            int worldItems,
            int eventBytes,
            int worldEventBytes) {}

    /**
     * The session token. Another connection can use it to resume the session within the given time
     * after the connection breaks.
     *
     * @param servers HOST:PORT of other servers that can continue the session
     */
    record Ticket(String token, double graceSeconds, List<String> servers) {

        /** Copies the list. */
        public Ticket {
            servers = List.copyOf(servers);
        }
    }

    /**
     * The lock-step settings in the welcome. The world waits for the agent after every Nth frame,
     * at most until the deadline.
     */
    record Rhythm(int every, double deadlineSeconds) {}

    /**
     * Reports that the client is connected, and describes its session.
     *
     * @param body name of the body of a client with the role agent
     * @param lockStep empty unless the client runs in lock-step
     * @param cameras names of the cameras of the body
     */
    record Welcome(
            long id,
            int protocol,
            Role role,
            String agent,
            Optional<String> body,
            String world,
            long frame,
            int rate,
            Encoding encoding,
            Optional<Rhythm> lockStep,
            Optional<Ticket> session,
            boolean resumed,
            Limits limits,
            List<String> cameras)
            implements ServerMessage {

        /** Copies the list. */
        public Welcome {
            cameras = List.copyOf(cameras);
        }
    }

    /** Reports that a command took effect in a frame. */
    record Accepted(long id, long frame) implements ServerMessage {}

    /**
     * The answer to a question.
     *
     * @param frame number of the frame whose state the answer describes
     * @param value a List or Map with values of type String, Boolean or Number, or with lists and
     *     maps of such values; keys are texts
     */
    record Answer(long id, long frame, Object value) implements ServerMessage {}

    /**
     * Reports that a command was refused.
     *
     * @param reason cut after {@value #MAX_REASON} characters
     */
    record Refused(long id, String code, String reason) implements ServerMessage {

        /** Maximum length of a reason [characters]. */
        static final int MAX_REASON = 8192;

        /** Shortens a reason that exceeds the maximum length. */
        public Refused {
            if (reason.length() > MAX_REASON) {
                int end =
                        MAX_REASON
                                - (Character.isHighSurrogate(reason.charAt(MAX_REASON - 1))
                                        ? 1
                                        : 0);
                reason =
                        reason.substring(0, end)
                                + "… (the first "
                                + end
                                + " of "
                                + reason.length()
                                + " characters)";
            }
        }
    }

    /**
     * The answer to a query.
     *
     * @param of type of the answered query in the protocol
     * @param content a Map with names as keys, and values of type String, Number, Boolean, or a
     *     List or Map of these; or a Fragment with such a Map
     */
    record Report(long id, long frame, String of, Object content) implements ServerMessage {}

    /** A picture from one of the agent's cameras. */
    record Image(long id, String sensor, Cameras.Photo photo) implements ServerMessage {}

    /**
     * An event of the world.
     *
     * @param fields String, Number, Boolean or a List of these by name
     */
    record Event(long frame, String type, Map<String, Object> fields) implements ServerMessage {

        /**
         * Returns the event {@code missed}, which reports that events of these frames were dropped.
         *
         * @param events number of dropped events; empty if unknown
         */
        public static Event missed(OptionalLong events, long first, long last) {
            var fields = new LinkedHashMap<String, Object>();
            events.ifPresent(count -> fields.put("events", count));
            fields.put("first", first);
            fields.put("last", last);
            return new Event(last, "missed", fields);
        }
    }

    /** Reports that a message was refused. */
    record Error(long id, String code, String message, String hint) implements ServerMessage {}

    /** Requests a pong. */
    record Ping() implements ServerMessage {}

    /** Answers a ping of the client. */
    record Pong(long id) implements ServerMessage {}

    /**
     * Reports that the connection ends, and why.
     *
     * @param address HOST:PORT of the server that has the client's world, if it is another one
     */
    record Bye(String code, String message, Optional<String> hint, Optional<String> address)
            implements ServerMessage {}

    /** Returns the encoded message. */
    default byte[] in(Encoding encoding) {
        var out = new Bytes();
        Map<String, Object> fields = fields();
        MessageWriter writer = encoding.begin(out, type(), id(), fields.size());
        fields.forEach(
                (name, value) -> {
                    writer.key(name);
                    writer.value(value);
                });
        encoding.end(out, 0);
        return out.toArray();
    }

    /** Returns the fields except type and id. */
    private Map<String, Object> fields() {
        var fields = new LinkedHashMap<String, Object>();
        switch (this) {
            case Welcome welcome -> putWelcome(welcome, fields);
            case Accepted accepted -> {
                fields.put("accepted", true);
                fields.put("frame", accepted.frame);
            }
            case Answer answer -> {
                fields.put("accepted", true);
                fields.put("frame", answer.frame);
                fields.put("value", answer.value);
            }
            case Refused refused -> {
                fields.put("accepted", false);
                fields.put("code", refused.code);
                fields.put("reason", refused.reason);
            }
            case Report report -> {
                fields.put("frame", report.frame);
                fields.put("of", report.of);
                fields.put("content", report.content);
            }
            case Image image -> putImage(image, fields);
            case Event event -> {
                fields.put("frame", event.frame);
                fields.put("type", event.type);
                fields.put("fields", event.fields);
            }
            case Error error -> {
                fields.put("code", error.code);
                fields.put("message", error.message);
                fields.put("hint", error.hint);
            }
            case Bye bye -> {
                fields.put("code", bye.code);
                fields.put("message", bye.message);
                bye.hint.ifPresent(hint -> fields.put("hint", hint));
                bye.address.ifPresent(address -> fields.put("address", address));
            }
            case Ping ping -> {}
            case Pong pong -> {}
        }
        return fields;
    }

    private String type() {
        return switch (this) {
            case Welcome welcome -> "welcome";
            case Accepted accepted -> "result";
            case Answer answer -> "result";
            case Refused refused -> "result";
            case Report report -> "report";
            case Image image -> "image";
            case Event event -> "event";
            case Error error -> "error";
            case Ping ping -> "ping";
            case Pong pong -> "pong";
            case Bye bye -> "bye";
        };
    }

    private static void putImage(Image image, Map<String, Object> fields) {
        Cameras.Photo photo = image.photo;
        fields.put("frame", photo.frame());
        fields.put("time", photo.time());
        fields.put("sensor", image.sensor);
        fields.put("width", photo.width());
        fields.put("height", photo.height());
        photo.colour().ifPresent(bytes -> fields.put("colour", bytes));
        photo.depth().ifPresent(bytes -> fields.put("depth", bytes));
        photo.items()
                .ifPresent(
                        bytes -> {
                            fields.put("items", bytes);
                            fields.put("names", photo.names());
                        });
    }

    private static void putWelcome(Welcome welcome, Map<String, Object> fields) {
        fields.put("protocol", welcome.protocol);
        fields.put("role", welcome.role.wireName());
        fields.put("agent", welcome.agent);
        welcome.body.ifPresent(body -> fields.put("body", body));
        fields.put("world", welcome.world);
        fields.put("frame", welcome.frame);
        fields.put("rate", welcome.rate);
        if (!welcome.cameras.isEmpty()) {
            fields.put("cameras", welcome.cameras);
        }
        if (welcome.encoding != Encoding.JSON) {
            fields.put("encoding", welcome.encoding.wireName());
        }
        welcome.lockStep.ifPresent(
                rhythm -> {
                    var time = new LinkedHashMap<String, Object>();
                    time.put("mode", "lock-step");
                    time.put("every", rhythm.every);
                    time.put("deadline", rhythm.deadlineSeconds);
                    fields.put("time", time);
                });
        welcome.session.ifPresent(
                session -> {
                    var ticket = new LinkedHashMap<String, Object>();
                    ticket.put("token", session.token);
                    ticket.put("graceSeconds", session.graceSeconds);
                    if (!session.servers.isEmpty()) {
                        ticket.put("servers", session.servers);
                    }
                    fields.put("session", ticket);
                });
        if (welcome.resumed) {
            fields.put("resumed", true);
        }
        var limits = new LinkedHashMap<String, Object>();
        limits.put("lineBytes", welcome.limits.lineBytes);
        limits.put("messagesPerSecond", welcome.limits.messagesPerSecond);
        limits.put("actsInFlight", welcome.limits.actsInFlight);
        limits.put("idleSeconds", welcome.limits.idleSeconds);
        limits.put("graceSeconds", welcome.limits.graceSeconds);
        limits.put("items", welcome.limits.items);
        limits.put("worldItems", welcome.limits.worldItems);
        limits.put("eventBytes", welcome.limits.eventBytes);
        limits.put("worldEventBytes", welcome.limits.worldEventBytes);
        fields.put("limits", limits);
    }
}
