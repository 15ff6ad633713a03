package reve.agent;

import java.util.OptionalLong;

/**
 * Who the agent is in which world.
 *
 * @param body name of the item that is its body
 * @param frame in which it joined
 * @param rate frames per second
 */
public record Welcome(OptionalLong id, int protocol, String agent, String body, String world, long frame, int rate,
        Limits limits) implements ServerMessage {

    /**
     * What the server takes from an agent.
     *
     * @param lineBytes longest line
     * @param actsInFlight most acts that wait for their result
     * @param idleSeconds silence after which it asks whether the agent is still there; the client answers by itself
     */
    public record Limits(int lineBytes, int actsInFlight, double idleSeconds) {}
}
