// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.agent.port.CarriedSession;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.ObjectNode;

import java.sql.Connection;
import java.sql.SQLException;
import java.util.ArrayList;
import java.util.List;
import java.util.OptionalLong;
import java.util.function.Consumer;

/** The sessions of a world that one server hands over to the next one, in a database. */
final class CarriedSessions {
    /** SQL that creates the table. The nodes of a cluster execute it when they start. */
    static final String TABLE =
            "CREATE TABLE IF NOT EXISTS reve.session (world text PRIMARY KEY, epoch bigint NOT"
                    + " NULL, frame bigint NOT NULL, sessions text NOT NULL)";

    private static final JsonMapper JSON = new JsonMapper();

    private CarriedSessions() {}

    /** Replaces the sessions of a world. */
    static void write(
            Connection connection,
            String world,
            long epoch,
            long frame,
            List<CarriedSession> sessions)
            throws SQLException {
        ArrayNode list = JSON.createArrayNode();
        for (CarriedSession session : sessions) {
            ObjectNode each = list.addObject();
            each.put("client", session.client());
            session.body().ifPresent(body -> each.put("body", body));
            each.put("state", session.state());
        }
        PostgresSession.update(
                connection,
                "INSERT INTO reve.session VALUES (?, ?, ?, ?) ON CONFLICT (world) DO UPDATE SET"
                        + " epoch = excluded.epoch, frame = excluded.frame,"
                        + " sessions = excluded.sessions",
                world,
                epoch,
                frame,
                Sealed.seal(list.toString()));
    }

    /**
     * Returns the sessions that continue. If the previous server ended regularly, these are the
     * sessions that it has handed over. If it was lost, or what it handed over cannot be read, they
     * are the sessions of its last frame. What cannot be read is reported.
     *
     * @param epoch the epoch of the server that continues the world
     */
    static List<CarriedSession> takeAll(
            Connection connection, String world, long epoch, long frame, Consumer<String> problems)
            throws SQLException {
        List<CarriedSession> handedOver = List.of();
        try {
            handedOver = take(connection, world, epoch - 1, frame);
        } catch (JacksonException | IllegalArgumentException otherForm) {
            problems.accept(
                    "the sessions that the previous server handed over at frame "
                            + frame
                            + " are damaged, or were written by another version ("
                            + NotedSessions.reason(otherForm)
                            + "); they continue as the notes of this frame have them, without"
                            + " the events that were not sent yet");
        }
        return handedOver.isEmpty()
                ? NotedSessions.read(connection, world, frame, problems)
                : handedOver;
    }

    /**
     * Returns the sessions that the server of an epoch handed over after a frame, and removes all
     * sessions of the world.
     *
     * @throws JacksonException if the sessions have an unknown format
     * @throws IllegalArgumentException if their checksum is wrong, or they are not a list
     */
    private static List<CarriedSession> take(
            Connection connection, String world, long epoch, long frame) throws SQLException {
        boolean isThere =
                PostgresSession.query(
                        connection,
                        "SELECT to_regclass('reve.session') IS NOT NULL",
                        rows -> rows.next() && rows.getBoolean(1));
        if (!isThere) {
            return List.of();
        }
        String text =
                PostgresSession.query(
                        connection,
                        "SELECT sessions FROM reve.session WHERE world = ? AND epoch = ? AND frame"
                                + " = ?",
                        rows -> rows.next() ? rows.getString(1) : "[]",
                        world,
                        epoch,
                        frame);
        PostgresSession.update(connection, "DELETE FROM reve.session WHERE world = ?", world);
        return read(text);
    }

    private static List<CarriedSession> read(String text) {
        List<CarriedSession> sessions = new ArrayList<>();
        JsonNode list = JSON.readTree(Sealed.open(text));
        if (!list.isArray()) {
            throw new IllegalArgumentException("it is no list");
        }
        for (JsonNode each : list) {
            sessions.add(
                    new CarriedSession(
                            each.required("client").stringValue(),
                            each.has("body")
                                    ? OptionalLong.of(each.get("body").longValue())
                                    : OptionalLong.empty(),
                            each.required("state").stringValue()));
        }
        return List.copyOf(sessions);
    }
}
