// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;
import java.util.OptionalLong;

/**
 * What a server says. Closed: an agent that meets anything else speaks another protocol version.
 */
public sealed interface ServerMessage
        permits Welcome,
                Perception,
                Update,
                Image,
                ActResult,
                WorldEvent,
                ServerMessage.Error,
                ServerMessage.Ping,
                ServerMessage.Pong,
                ServerMessage.Bye {

    /** A message was refused; the connection goes on. */
    record Error(OptionalLong id, String code, String message, Optional<String> hint)
            implements ServerMessage {}

    /** The server asks whether we are still there. */
    record Ping() implements ServerMessage {}

    /** The server is still there. */
    record Pong(OptionalLong id) implements ServerMessage {}

    /** The connection ends, and why. */
    record Bye(String code, String message, Optional<String> hint) implements ServerMessage {}
}
