// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;

/**
 * The interface through which a connection uses its session. The session begins with the client's
 * hello. Called on the event loop's thread, except where stated.
 */
public interface Client {

    /** Returns whether the message quota allows one more message now. */
    boolean hasQuota();

    /** Counts a received message against the quota. */
    void count();

    /** Records a request of the client for perceptions. */
    void perceive(ClientMessage.Perceive perceive) throws BadMessage;

    /**
     * Requests a picture from a camera. The picture is sent as soon as it is drawn. For any thread
     * if the message names the body that carries the camera.
     */
    void look(ClientMessage.Look look) throws BadMessage;

    /** Ends the current round of an agent in lock-step. */
    void ready(ClientMessage.Ready ready) throws BadMessage;

    /**
     * Executes a command, unless a command with the same id was received before. For any thread.
     */
    void request(ClientMessage.Request request) throws BadMessage;

    /**
     * Handles the end of a connection. The session waits for a new connection or ends if this
     * connection was its current one. For any thread.
     */
    void disconnected(Outbox outbox, CloseReason why);

    /** Returns the encoder for the perceptions of the client's world. */
    PerceptionEncoder encoder();

    /**
     * Charges the time for writing a perception [ns] to the client's share of the event loop's
     * time. Called on the thread that writes to the connection.
     */
    void wrotePerception(long nanos);

    /** Returns the name of the client's world. */
    String worldName();

    /** Returns the name that the client declared. */
    String name();
}
