// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;
import java.util.OptionalLong;

/**
 * A message from a server. The interface is sealed, because any other message belongs to another
 * version of the protocol.
 */
public sealed interface ServerMessage
        permits Welcome,
                Perception,
                Update,
                Image,
                Report,
                ActResult,
                WorldEvent,
                ServerMessage.Error,
                ServerMessage.Ping,
                ServerMessage.Pong,
                ServerMessage.Bye {

    /** Reports that a message was refused. The connection continues. */
    record Error(OptionalLong id, String code, String message, Optional<String> hint)
            implements ServerMessage {}

    /** Requests a pong. */
    record Ping() implements ServerMessage {}

    /** Answers a ping. */
    record Pong(OptionalLong id) implements ServerMessage {}

    /** Reports that the connection ends. */
    record Bye(String code, String message, Optional<String> hint, Optional<String> address)
            implements ServerMessage {}
}
