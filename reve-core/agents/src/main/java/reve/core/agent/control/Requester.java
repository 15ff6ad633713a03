// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.control;

import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.ServerMessage;

import java.util.Optional;

/**
 * The client that sent a command. The code that executes commands returns their results through
 * this interface. For any thread.
 */
public interface Requester {

    /** Returns the name that the client declared. */
    String name();

    /** Returns whether the client has the role control. */
    boolean controls();

    /** Returns why the client may not change a library of laws; empty if it may. */
    default Optional<String> refusalOfLaw(String library) {
        return Optional.empty();
    }

    /** Returns the encoding of messages to the client. */
    Encoding encoding();

    /** Ends the current round of an agent in lock-step. */
    void endRound(ClientMessage.Ready ready);

    /** Sends the result of a command, and the frame in which it took effect. */
    void finish(ClientMessage.Request request, ServerMessage result, long frame);

    /** Returns whether the results of the client's commands are noted as soon as they are known. */
    default boolean notesResults() {
        return false;
    }

    /**
     * Notes the result of a command on the world's thread, in the frame that executed it. {@link
     * #finish} sends the result later.
     */
    default void note(ServerMessage result) {
        // Most requesters do not survive the loss of this server.
    }

    /** Refuses a command that cannot be executed now. The client may send the command again. */
    void refuse(ClientMessage.Request request, String code, String reason);

    /**
     * Sends the answer to a query. The answer is not stored, so the client may ask again.
     *
     * @return false if the answer exceeds the limit on waiting data
     */
    boolean answer(ClientMessage.Request request, byte[] line);
}
