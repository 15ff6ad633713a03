package reve.core.file;

import java.util.List;
import java.util.Optional;
import reve.core.world.ItemDefinition;

/**
 * Which bodies a world grants to agents; none unless the world file says so.
 *
 * @param bodies names of items that agents may take, in the order in which they are given out
 * @param template what a new body is made of for an agent that gets none of those; whoever takes it
 *     renames it
 */
public record AgentPolicy(List<String> bodies, Optional<ItemDefinition> template) {
    public AgentPolicy {
        bodies = List.copyOf(bodies);
    }

    /** A world without agents. */
    public static AgentPolicy none() {
        return new AgentPolicy(List.of(), Optional.empty());
    }
}
