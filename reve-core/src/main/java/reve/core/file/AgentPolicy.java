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
 * @param places where new bodies come into the world, one each; without, where the template is
 */
public record AgentPolicy(List<String> bodies, Optional<ItemDefinition> template,
        List<Place> places) {
    public AgentPolicy {
        bodies = List.copyOf(bodies);
        places = List.copyOf(places);
    }

    /** A point of the world [m]. */
    public record Place(double x, double y, double z) {}

    /** New bodies come to where the template is. */
    public AgentPolicy(List<String> bodies, Optional<ItemDefinition> template) {
        this(bodies, template, List.of());
    }

    /** A world without agents. */
    public static AgentPolicy none() {
        return new AgentPolicy(List.of(), Optional.empty());
    }
}
