// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;

/**
 * The session behind a connection after its hello. Called on the event loop's thread, except where
 * stated.
 */
public interface Client {

    /** Returns whether the message quota allows one more message now. */
    boolean hasQuota();

    /** Counts a received message against the quota. */
    void count();

    /** Records which perceptions the client requests. */
    void perceive(ClientMessage.Perceive perceive) throws BadMessage;

    /** Requests a picture from a camera of the client's body, and sends it. */
    void look(ClientMessage.Look look) throws BadMessage;

    /** Ends the agent's round. */
    void ready(ClientMessage.Ready ready) throws BadMessage;

    /** Executes a command, unless a command with the same id was received before. Any thread. */
    void request(ClientMessage.Request request) throws BadMessage;

    /**
     * Handles the end of a connection. If it was this client's current connection, the session
     * waits for a new one or ends. Any thread.
     */
    void disconnected(Outbox outbox, CloseReason why);

    /** Returns the encoder for the perceptions of the client's world. */
    PerceptionEncoder encoder();

    /**
     * Charges the time for writing a perception [ns]. Called on the thread that writes to the
     * connection.
     */
    void wrotePerception(long nanos);

    /** Returns the name of the client's world. */
    String worldName();

    /** Returns the name that the client declared. */
    String name();
}
