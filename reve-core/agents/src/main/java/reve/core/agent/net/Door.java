// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;

/** Lets clients in. */
public interface Door {

    /**
     * Lets a client in, or lets it go on where its last connection broke. The event loop's thread.
     *
     * @return its session; the welcome comes when the world has taken it
     * @throws CloseReason if it cannot come in
     */
    Client greet(Connection connection, ClientMessage.Hello hello) throws CloseReason;
}
