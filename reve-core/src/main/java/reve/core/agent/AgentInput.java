package reve.core.agent;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * What an agent does to the world, as data: with the frame and the place in its order it is all that a recording
 * needs, since {@link Members#apply} depends on nothing else but the world.
 */
public sealed interface AgentInput {

    /** The name that the agent declared. */
    String agent();

    /** @param body the lent item that it asks for */
    record Join(String agent, Optional<String> body) implements AgentInput {}

    /** @param arguments Double, List of Double, String or Boolean by parameter name, not yet checked */
    record Act(String agent, String item, String action, Map<String, Object> arguments) implements AgentInput {
        public Act {
            arguments = Collections.unmodifiableMap(new LinkedHashMap<>(arguments));
        }
    }

    /** @param reason a code, for the others */
    record Leave(String agent, String reason) implements AgentInput {}
}
