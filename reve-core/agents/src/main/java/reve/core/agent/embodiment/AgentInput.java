// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.auth.Rights;
import reve.core.agent.protocol.ClientMessage;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * What a client does to the world, as data: with the frame and the place in its order it is all
 * that a recording needs, since {@link Embodiment#apply} depends on nothing else but the world.
 */
public sealed interface AgentInput {

    /** The name that the client declared. */
    String agent();

    /**
     * @param body the lent item that it asks for
     * @param rights what it may have and do
     */
    record Join(String agent, Optional<String> body, Rights rights) implements AgentInput {}

    /**
     * @param arguments Double, List of Double, String or Boolean by parameter name, not yet checked
     */
    record Act(String agent, String item, String action, Map<String, Object> arguments)
            implements AgentInput {
        /** Copies the arguments. */
        public Act {
            arguments = Collections.unmodifiableMap(new LinkedHashMap<>(arguments));
        }
    }

    /**
     * A change by an operator, whom nothing is refused that the world can do.
     *
     * @param property {@code physical.location}, {@code physics.mass}, {@code semantic.class}
     * @param value Double, List of Double, String or Boolean
     */
    record Edit(String agent, String item, String property, Object value) implements AgentInput {}

    /**
     * An agent in lock-step did not say in time what it does.
     *
     * @param count how often it was late until now
     * @param fallback what its body does instead
     * @param told whether the others hear of it
     * @param away true if it was late so often in a row that the world no longer waits for it
     */
    record Late(
            String agent,
            long count,
            Optional<ClientMessage.Fallback> fallback,
            boolean told,
            boolean away)
            implements AgentInput {}

    /** An agent in lock-step that was away has been ready: the world waits for it again. */
    record Back(String agent) implements AgentInput {}

    /**
     * @param reason a code, for the others
     */
    record Leave(String agent, String reason) implements AgentInput {}
}
