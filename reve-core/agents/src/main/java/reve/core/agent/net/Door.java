// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;

/** Admits clients by their first message, the hello. */
public interface Door {

    /**
     * Admits a client, or resumes the session of its broken connection. Called on the event loop's
     * thread.
     *
     * @return the session; its welcome is sent after the world has executed the join
     * @throws CloseReason if the client is refused
     */
    Client greet(Connection connection, ClientMessage.Hello hello) throws CloseReason;
}
