// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;

/** A client as the control desk sees it: gives commands, and is sent their results. Any thread. */
public interface Requester {

    /** Returns the name that the client declared. */
    String name();

    /** Returns how messages to it are written. */
    Encoding encoding();

    /** Ends its round, if the agent is in lock-step. */
    void endRound(ClientMessage.Ready ready);

    /** Sends the result of a command that took effect in a frame. */
    void finish(ClientMessage.Request request, ServerMessage result, long frame);

    /** Refuses a command that cannot be done now; it may be sent again. */
    void refuse(ClientMessage.Request request, String code, String reason);

    /**
     * Sends the answer to a question, which nobody remembers; it may be asked again.
     *
     * @return false if it is more than a client is sent at once
     */
    boolean answer(ClientMessage.Request request, byte[] line);
}
