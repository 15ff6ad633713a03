// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.auth.Rights;
import reve.core.agent.protocol.ActionRequest;

import java.util.Optional;

/**
 * An input of a client to the world, as data. The result of {@link Embodiment#apply} depends only
 * on the input and the world. Therefore a recording stores only the inputs, with their frames and
 * order.
 */
public sealed interface AgentInput {

    /** Returns the name that the client declared. */
    String agent();

    /**
     * Gives a body in the world to an agent.
     *
     * @param body name of the item that the agent requests as its body
     * @param rights rights of the client
     */
    record Join(String agent, Optional<String> body, Rights rights) implements AgentInput {}

    /** An action that the agent's body performs. */
    record Act(String agent, ActionRequest requested) implements AgentInput {}

    /**
     * A change by an operator, possibly any change that the world permits.
     *
     * @param property the name of the property, for example {@code physical.location}, {@code
     *     physics.mass} or {@code semantic.class}
     * @param value Double, List of Double, String or Boolean
     */
    record Edit(String agent, String item, String property, Object value) implements AgentInput {}

    /**
     * Reports that an agent in lock-step missed its deadline.
     *
     * @param count number of missed deadlines so far
     * @param fallback the action that its body performs instead
     * @param told true if an event notifies the other agents
     * @param away true if the agent missed so many deadlines in a row that the world no longer
     *     waits for it
     */
    record Late(
            String agent, long count, Optional<ActionRequest> fallback, boolean told, boolean away)
            implements AgentInput {}

    /**
     * Reports that an agent in lock-step is ready after the world had stopped waiting for it. The
     * world waits for this agent again.
     */
    record Back(String agent) implements AgentInput {}

    /**
     * Takes the body from an agent that leaves the world.
     *
     * @param reason code of the reason, which other agents receive
     */
    record Leave(String agent, String reason) implements AgentInput {}
}
