// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Optional;
import java.util.OptionalInt;
import java.util.OptionalLong;

/**
 * Who the agent is in which world.
 *
 * @param role "agent", "control" or "observer"
 * @param body name of the item that is its body; only agents have one
 * @param frame in which it joined
 * @param rate frames per second
 * @param encoding "json" or "msgpack"
 * @param lockStep the rhythm and the deadline that an agent in lock-step has got
 * @param session given to who asked for grace
 * @param resumed true if a session goes on after its connection broke
 */
public record Welcome(
        OptionalLong id,
        int protocol,
        String role,
        String agent,
        Optional<String> body,
        String world,
        long frame,
        int rate,
        String encoding,
        Optional<LockStep> lockStep,
        Optional<Ticket> session,
        boolean resumed,
        Limits limits)
        implements ServerMessage {

    /**
     * With the token another connection goes on with the session, that long [s] after the first
     * broke.
     */
    public record Ticket(String token, double graceSeconds) {}

    /**
     * What the server takes from an agent. Limits that the server does not have are empty.
     *
     * @param lineBytes longest line
     * @param messagesPerSecond most messages that it takes in a second, or in lock-step in one of
     *     the world's if that goes faster; the others wait
     * @param actsInFlight most commands that may wait for their result
     * @param idleSeconds silence after which it asks whether the agent is still there; the client
     *     answers by itself
     * @param graceSeconds the most that one can ask for
     * @param items most items in the world at a time that the agent's actions created
     * @param worldItems most items in the world at a time that actions of all agents created
     * @param eventBytes most bytes of events in a second of world time that its actions raise
     * @param worldEventBytes most bytes of events in a second of world time that actions of all
     *     agents raise
     */
    public record Limits(
            int lineBytes,
            int messagesPerSecond,
            int actsInFlight,
            double idleSeconds,
            double graceSeconds,
            OptionalInt items,
            OptionalInt worldItems,
            OptionalInt eventBytes,
            OptionalInt worldEventBytes) {}
}
