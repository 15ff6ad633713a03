// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;
import reve.core.agent.protocol.ServerMessage;

import java.util.Optional;

/** Admits clients by their first message, the hello. */
public interface Door {

    /**
     * Answers a client that asks a question instead of joining a world. Called on the event loop's
     * thread.
     *
     * @return the answer; empty if the hello asks no question
     * @throws CloseReason if the client is refused
     */
    Optional<ServerMessage> answer(Connection connection, ClientMessage.Hello hello)
            throws CloseReason;

    /**
     * Admits a client, or resumes the session of its broken connection. Called on the event loop's
     * thread.
     *
     * @return the session; its welcome is sent after the world has executed the join
     * @throws CloseReason if the client is refused
     */
    Client greet(Connection connection, ClientMessage.Hello hello) throws CloseReason;
}
