// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import reve.core.agent.port.CarriedSession;
import reve.core.agent.port.FinishedCommand;
import reve.core.agent.port.SessionNote;

import tools.jackson.core.JacksonException;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;
import tools.jackson.databind.node.ArrayNode;
import tools.jackson.databind.node.ObjectNode;

import java.sql.Connection;
import java.sql.SQLException;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Deque;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;
import java.util.TreeMap;
import java.util.function.Consumer;

/**
 * The sessions of a world after a frame, as the notes in the store describe them. The server that
 * continues the world after the loss of this server reads them. The store has a row for each frame
 * with notes. When it writes an image, it replaces these rows by one row with all sessions. For one
 * thread.
 */
final class NotedSessions {
    /**
     * SQL that creates the table. The nodes of a cluster execute it when they start. In rows that
     * are {@code whole}, the notes replace all earlier notes.
     */
    static final String TABLE =
            "CREATE TABLE IF NOT EXISTS reve.session_note (world text, epoch bigint, frame bigint,"
                    + " whole boolean NOT NULL, notes text NOT NULL,"
                    + " PRIMARY KEY (world, epoch, frame))";

    /**
     * Maximum number of results that are kept for each session. A client may wait for at most 64
     * results. Commands whose results are not kept are refused if the client sends them again.
     */
    static final int REMEMBERED = 256;

    private static final JsonMapper JSON = new JsonMapper();

    private final Map<String, Session> sessions = new TreeMap<>();

    /** A session, and the results that were added after its state was written. */
    private static final class Session {
        private final CarriedSession begun;
        private final Deque<FinishedCommand> finished = new ArrayDeque<>();
        private long forgottenId = -1;

        Session(CarriedSession begun) {
            this.begun = begun;
            begun.since()
                    .ifPresent(
                            since -> {
                                forgottenId = since.forgottenId();
                                since.finished().forEach(this::add);
                            });
        }

        void add(FinishedCommand command) {
            if (finished.size() == REMEMBERED) {
                forgottenId = Math.max(forgottenId, finished.removeFirst().id());
            }
            finished.addLast(command);
        }

        CarriedSession carried() {
            return new CarriedSession(
                    begun.client(),
                    begun.body(),
                    begun.state(),
                    Optional.of(new CarriedSession.Since(List.copyOf(finished), forgottenId)));
        }
    }

    /** Applies notes in their order. Ignores results of clients that have no session. */
    void apply(List<SessionNote> notes) {
        for (SessionNote note : notes) {
            switch (note) {
                case SessionNote.Began began ->
                        sessions.put(began.client(), new Session(began.session()));
                case SessionNote.Finished done -> {
                    Session session = sessions.get(done.client());
                    if (session != null) {
                        session.add(done.command());
                    }
                }
                case SessionNote.Ended ended -> sessions.remove(ended.client());
            }
        }
    }

    /** Returns the sessions, by the names of their clients. */
    List<CarriedSession> all() {
        return sessions.values().stream().map(Session::carried).toList();
    }

    /**
     * Encodes all sessions as notes that replace all earlier notes; empty if there are no sessions.
     */
    String whole() {
        return sessions.isEmpty()
                ? ""
                : write(all().stream().<SessionNote>map(SessionNote.Began::new).toList());
    }

    /** Encodes notes as a text. */
    static String write(List<SessionNote> notes) {
        ArrayNode list = JSON.createArrayNode();
        for (SessionNote note : notes) {
            ObjectNode each = list.addObject();
            each.put("client", note.client());
            switch (note) {
                case SessionNote.Began began -> {
                    CarriedSession session = began.session();
                    session.body().ifPresent(body -> each.put("body", body));
                    each.put("state", session.state());
                    session.since()
                            .ifPresent(
                                    since -> {
                                        each.put("forgotten", since.forgottenId());
                                        ArrayNode done = each.putArray("done");
                                        since.finished()
                                                .forEach(
                                                        command -> write(done.addArray(), command));
                                    });
                }
                case SessionNote.Finished done -> write(each.putArray("result"), done.command());
                case SessionNote.Ended _ -> each.put("ended", true);
            }
        }
        return Sealed.seal(list.toString());
    }

    private static void write(ArrayNode parts, FinishedCommand command) {
        parts.add(command.id()).add(command.frame());
        if (!command.isAccepted()) {
            parts.add(command.code()).add(command.reason());
        }
    }

    private static List<SessionNote> parse(String text) {
        List<SessionNote> notes = new ArrayList<>();
        JsonNode list = JSON.readTree(Sealed.open(text));
        if (!list.isArray()) {
            throw new IllegalArgumentException("it is no list");
        }
        for (JsonNode each : list) {
            String client = each.required("client").stringValue();
            if (each.has("state")) {
                List<FinishedCommand> done = new ArrayList<>();
                each.path("done").forEach(parts -> done.add(command(parts)));
                notes.add(
                        new SessionNote.Began(
                                new CarriedSession(
                                        client,
                                        each.has("body")
                                                ? OptionalLong.of(each.get("body").longValue())
                                                : OptionalLong.empty(),
                                        each.get("state").stringValue(),
                                        Optional.of(
                                                new CarriedSession.Since(
                                                        done,
                                                        each.path("forgotten").longValue(-1))))));
            } else if (each.has("result")) {
                notes.add(new SessionNote.Finished(client, command(each.get("result"))));
            } else {
                notes.add(new SessionNote.Ended(client));
            }
        }
        return notes;
    }

    private static FinishedCommand command(JsonNode parts) {
        return new FinishedCommand(
                parts.required(0).longValue(),
                parts.required(1).longValue(),
                parts.path(2).stringValue(""),
                parts.path(3).stringValue(""));
    }

    /** Returns whether the database has the table. */
    static boolean areKept(Connection connection) throws SQLException {
        return PostgresSession.query(
                connection,
                "SELECT to_regclass('reve.session_note') IS NOT NULL",
                rows -> rows.next() && rows.getBoolean(1));
    }

    /**
     * Returns the sessions of a world after its last frame. If the server that wrote this frame
     * stores no notes, the result is empty.
     *
     * @param frame the last frame of the world
     * @param problems receives a message about each row that cannot be read. The sessions of the
     *     rows before such a row are lost, because the row may have changed them.
     */
    static List<CarriedSession> read(
            Connection connection, String world, long frame, Consumer<String> problems)
            throws SQLException {
        List<Row> rows =
                PostgresSession.query(
                        connection,
                        "SELECT frame, whole, notes FROM reve.session_note WHERE world = ? AND"
                                + " frame <= ? AND epoch = (SELECT max(epoch) FROM (SELECT epoch"
                                + " FROM reve.image WHERE world = ? UNION ALL SELECT epoch FROM"
                                + " reve.frame WHERE world = ?) AS written) ORDER BY frame",
                        found -> {
                            List<Row> all = new ArrayList<>();
                            while (found.next()) {
                                if (found.getBoolean(2)) {
                                    all.clear();
                                }
                                all.add(new Row(found.getLong(1), found.getString(3)));
                            }
                            return all;
                        },
                        world,
                        frame,
                        world,
                        world);
        NotedSessions sessions = new NotedSessions();
        for (Row row : rows) {
            try {
                sessions.apply(parse(row.notes));
            } catch (JacksonException | IllegalArgumentException unreadable) {
                sessions.sessions.clear();
                problems.accept(
                        "the notes about sessions of frame "
                                + row.frame
                                + " are damaged, or were written by another version ("
                                + reason(unreadable)
                                + "); the agents whose sessions began before this frame join"
                                + " again");
            }
        }
        return sessions.all();
    }

    private record Row(long frame, String notes) {}

    static String reason(RuntimeException unreadable) {
        return unreadable instanceof JacksonException json
                ? json.getOriginalMessage()
                : String.valueOf(unreadable.getMessage());
    }

    /**
     * Replaces the rows of a world up to a frame.
     *
     * @param whole the sessions after this frame, as {@link #whole} returned them
     */
    static void replace(Connection connection, String world, long epoch, long frame, String whole)
            throws SQLException {
        PostgresSession.update(
                connection,
                "DELETE FROM reve.session_note WHERE world = ? AND (epoch <> ? OR frame <= ?)",
                world,
                epoch,
                frame);
        if (!whole.isEmpty()) {
            PostgresSession.update(
                    connection,
                    "INSERT INTO reve.session_note VALUES (?, ?, ?, true, ?)",
                    world,
                    epoch,
                    frame,
                    whole);
        }
    }
}
