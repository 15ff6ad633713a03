// SPDX-License-Identifier: Apache-2.0
package reve.worlds.journal;

import java.io.IOException;
import java.sql.SQLException;
import java.util.Set;

/** Messages for operations of a PostgreSQL database that failed. */
final class PostgresTrouble {
    private static final int CLASS_LENGTH = 2;

    /** Classes of temporary failures: no connection, and a database that restarts. */
    private static final Set<String> AWAY = Set.of("08", "57");

    private PostgresTrouble() {}

    /**
     * Returns an exception with a message for a failed operation.
     *
     * @param what the operation, as a participle such as "read"
     */
    static IOException of(PostgresUrl url, String what, SQLException e) {
        String message = url + " could not be " + what + ": " + reason(url, e);
        IOException trouble =
                isAway(e) ? new JournalSink.AwayException(message) : new IOException(message);
        trouble.initCause(e);
        return trouble;
    }

    /** Returns whether the database cannot be reached at present. */
    static boolean isAway(SQLException e) {
        return AWAY.contains(stateClass(e));
    }

    /** Returns the first two characters of the SQL state, which name the class of the failure. */
    private static String stateClass(SQLException e) {
        String state = e.getSQLState();
        return state == null || state.length() < CLASS_LENGTH
                ? ""
                : state.substring(0, CLASS_LENGTH);
    }

    private static String reason(PostgresUrl url, SQLException e) {
        String state = e.getSQLState() == null ? "" : e.getSQLState();
        String message = String.valueOf(e.getMessage()).replaceAll("\\s*\\R\\s*", " ");
        String advice =
                switch (state) {
                    case "3D000" -> "; create the database: createdb " + url.database();
                    case "42501" ->
                            "; permit the user "
                                    + url.user()
                                    + " to create the schema reve: GRANT CREATE ON DATABASE "
                                    + url.database()
                                    + " TO "
                                    + url.user();
                    case "53100" -> "; the disk of the database is full, make room on it";
                    case "53300" ->
                            "; a server opens two connections for each world, raise max_connections"
                                    + " of the database";
                    default ->
                            switch (stateClass(e)) {
                                case "28" ->
                                        "; write the password of "
                                                + url.user()
                                                + " into ~/.pgpass (HOST:PORT:DATABASE:USER:PASSWORD,"
                                                + " mode 600)";
                                case "08", "57" ->
                                        "; see that the database runs and can be reached";
                                default -> "";
                            };
                };
        return message + advice;
    }
}
