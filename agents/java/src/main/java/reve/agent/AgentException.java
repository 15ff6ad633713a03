// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.time.Duration;
import java.util.Optional;

/**
 * The exception for a server that refused a message, ended the connection, or did not answer.
 * Programs read the code. People read the message, which ends with the hint, if there is one.
 */
public class AgentException extends RuntimeException {

    private static final long serialVersionUID = 1L;

    /** Code of the error as in the protocol. */
    private final String code;

    private final transient Optional<String> hint;

    AgentException(String code, String message, Optional<String> hint) {
        super(code + ": " + message + hint.map(text -> " (" + text + ")").orElse(""));
        this.code = code;
        this.hint = hint;
    }

    static AgentException refused(ServerMessage.Error error) {
        return new AgentException(error.code(), error.message(), error.hint());
    }

    static AgentException unexpected(ServerMessage message) {
        return new AgentException(
                "protocol",
                "the server sent a message that was not requested: " + message,
                Optional.empty());
    }

    static AgentException tooLong(long bytes, int most) {
        return new AgentException(
                "protocol",
                "the server sent a message of "
                        + bytes
                        + " bytes or more, expected at most "
                        + most
                        + " bytes",
                Optional.empty());
    }

    static AgentException unreadable(RuntimeException e) {
        return new AgentException(
                "protocol",
                "the server sent a message that cannot be read: " + e,
                Optional.empty());
    }

    static AgentException noAnswer(Duration waited) {
        return new AgentException(
                "no-answer",
                "the server was silent for " + waited.toMillis() / 1000.0 + " s",
                Optional.of("is its world running?"));
    }

    /**
     * Returns a code of the protocol, {@code no-answer} if the server did not answer, or {@code
     * protocol} for an invalid message.
     */
    public String code() {
        return code;
    }

    /** Returns the server's advice how to avoid the error. */
    public Optional<String> hint() {
        return hint;
    }
}
