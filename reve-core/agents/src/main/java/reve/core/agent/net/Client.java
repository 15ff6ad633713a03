// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import reve.core.agent.perception.PerceptionEncoder;
import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.CloseReason;

/**
 * The session behind a connection that has said hello. The event loop's thread, but where said
 * otherwise.
 */
public interface Client {

    /** Returns true if one more message of it may be taken now. */
    boolean hasQuota();

    /** Counts a message that is taken. */
    void count();

    /** Notes what the client asks to perceive. */
    void perceive(ClientMessage.Perceive perceive) throws BadMessage;

    /** Has a picture taken by a camera of its body, and sent. */
    void look(ClientMessage.Look look) throws BadMessage;

    /** Ends the agent's round. */
    void ready(ClientMessage.Ready ready) throws BadMessage;

    /** Has a command done, unless it was given before. Any thread. */
    void request(ClientMessage.Request request) throws BadMessage;

    /** A connection has ended; if it was this client's, the session breaks or ends. Any thread. */
    void disconnected(Connection ended, CloseReason why);

    /** Returns what writes the perceptions of its world. */
    PerceptionEncoder encoder();

    /** A perception was written in so much time, on whichever thread writes to it. */
    void wrotePerception(long nanos);

    /** Returns the name of its world. */
    String worldName();

    /** Returns the name that it declared. */
    String name();
}
