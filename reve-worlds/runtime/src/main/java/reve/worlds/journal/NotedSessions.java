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

import java.nio.charset.StandardCharsets;
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
import java.util.TreeSet;
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

    /** SQL condition: the database has the table, and the columns for {@link #reference}. */
    static final String ARE_KEPT =
            "to_regclass('reve.session_note') IS NOT NULL AND (SELECT count(*) FROM pg_attribute"
                    + " WHERE attrelid IN (to_regclass('reve.image'), to_regclass('reve.frame'))"
                    + " AND attname = 'notes' AND NOT attisdropped) = 2";

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

    /** Returns whether the database has the table and the columns, so that notes can be written. */
    static boolean areKept(Connection connection) throws SQLException {
        return isTrue(connection, ARE_KEPT);
    }

    /** Returns whether the database has the table. */
    private static boolean isThere(Connection connection) throws SQLException {
        return isTrue(connection, "to_regclass('reve.session_note') IS NOT NULL");
    }

    private static boolean isTrue(Connection connection, String condition) throws SQLException {
        return PostgresSession.query(
                connection, "SELECT " + condition, rows -> rows.next() && rows.getBoolean(1));
    }

    /**
     * Returns a checksum of a row of notes. The row of its frame or image has the same number in
     * its column {@code notes}, so that missing and moved rows are noticed.
     *
     * @param text the notes; empty if an image has no row
     */
    static long reference(String text, long epoch, long frame, boolean isWhole) {
        return StoreDatabase.checksum(
                text.getBytes(StandardCharsets.UTF_8), epoch, frame, isWhole ? 1 : 0);
    }

    /**
     * Returns the sessions of a world after its last frame. If the server that wrote this frame
     * stores no notes, or the database has no table for them, the result is empty.
     *
     * @param frame the last frame of the world
     * @param problems receives a message about each row that is missing or cannot be read. The
     *     sessions of the rows before such a row are lost, because the row may have changed them.
     */
    static List<CarriedSession> read(
            Connection connection, String world, long frame, Consumer<String> problems)
            throws SQLException {
        if (!isThere(connection)) {
            return List.of();
        }
        long epoch =
                PostgresSession.query(
                        connection,
                        "SELECT max(epoch) FROM (SELECT epoch FROM reve.image WHERE world = ? UNION"
                                + " ALL SELECT epoch FROM reve.frame WHERE world = ?) AS written",
                        rows -> rows.next() ? rows.getLong(1) : 0L,
                        world,
                        world);
        TreeMap<Long, Row> rows = rows(connection, world, epoch, frame);
        TreeMap<Long, Long> references =
                areKept(connection) ? references(connection, world, epoch, frame) : new TreeMap<>();
        boolean isChecked = !references.isEmpty(); // earlier versions wrote no references
        TreeSet<Long> noted = new TreeSet<>(references.keySet());
        noted.addAll(isChecked ? rows.tailMap(references.firstKey()).keySet() : rows.keySet());
        NotedSessions sessions = new NotedSessions();
        String problem = "";
        for (long each : noted) {
            Row row = rows.getOrDefault(each, new Row(true, ""));
            try {
                if (isChecked && row.reference(epoch, each) != references.getOrDefault(each, -1L)) {
                    throw new IllegalArgumentException(
                            rows.containsKey(each)
                                    ? "they do not belong to this frame"
                                    : "the row is missing");
                }
                if (row.isWhole) {
                    sessions.sessions.clear();
                }
                if (rows.containsKey(each)) {
                    sessions.apply(parse(row.notes));
                }
            } catch (JacksonException | IllegalArgumentException unreadable) {
                sessions.sessions.clear();
                problem =
                        "the notes about sessions of frame "
                                + each
                                + " are damaged, or were written by another version ("
                                + reason(unreadable)
                                + "); the agents whose sessions began before this frame join"
                                + " again";
            }
        }
        if (!problem.isEmpty()) {
            problems.accept(problem);
        }
        return sessions.all();
    }

    private record Row(boolean isWhole, String notes) {
        long reference(long epoch, long frame) {
            return NotedSessions.reference(notes, epoch, frame, isWhole);
        }
    }

    private static TreeMap<Long, Row> rows(
            Connection connection, String world, long epoch, long frame) throws SQLException {
        return PostgresSession.query(
                connection,
                "SELECT frame, whole, notes FROM reve.session_note WHERE world = ? AND epoch = ?"
                        + " AND frame <= ?",
                found -> {
                    TreeMap<Long, Row> rows = new TreeMap<>();
                    while (found.next()) {
                        rows.put(
                                found.getLong(1), new Row(found.getBoolean(2), found.getString(3)));
                    }
                    return rows;
                },
                world,
                epoch,
                frame);
    }

    /**
     * Returns the references of the newest image and of the frames after it, by frame. Empty if an
     * earlier version wrote the image.
     */
    private static TreeMap<Long, Long> references(
            Connection connection, String world, long epoch, long frame) throws SQLException {
        return PostgresSession.query(
                connection,
                "WITH newest AS (SELECT frame, notes FROM reve.image WHERE world = ? AND epoch = ?"
                        + " AND frame <= ? ORDER BY number DESC LIMIT 1) SELECT frame, notes FROM"
                        + " newest WHERE notes IS NOT NULL UNION ALL SELECT frame, notes FROM"
                        + " reve.frame WHERE world = ? AND epoch = ? AND frame <= ? AND notes IS NOT"
                        + " NULL AND frame > (SELECT frame FROM newest WHERE notes IS NOT NULL)",
                found -> {
                    TreeMap<Long, Long> references = new TreeMap<>();
                    while (found.next()) {
                        references.put(found.getLong(1), found.getLong(2));
                    }
                    return references;
                },
                world,
                epoch,
                frame,
                world,
                epoch,
                frame);
    }

    static String reason(RuntimeException unreadable) {
        return unreadable instanceof JacksonException json
                ? json.getOriginalMessage()
                : String.valueOf(unreadable.getMessage());
    }

    /**
     * Replaces the rows of a world up to the frame of an image.
     *
     * @param image number of the image
     * @param frame its frame
     * @param whole the sessions after this frame, as {@link #whole} returned them
     */
    static void replace(
            Connection connection, String world, long epoch, long image, long frame, String whole)
            throws SQLException {
        PostgresSession.update(
                connection,
                "DELETE FROM reve.session_note WHERE world = ? AND (epoch <> ? OR frame <= ?)",
                world,
                epoch,
                frame);
        PostgresSession.update(
                connection,
                "UPDATE reve.image SET notes = ? WHERE world = ? AND epoch = ? AND number = ?",
                reference(whole, epoch, frame, true),
                world,
                epoch,
                image);
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
