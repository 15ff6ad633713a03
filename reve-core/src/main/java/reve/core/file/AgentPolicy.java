package reve.core.file;

import java.util.List;
import java.util.Optional;
import reve.core.world.ItemDefinition;

/**
 * Which bodies a world grants to agents, none unless the world file says so; and how many items
 * their actions may have in it at a time.
 *
 * @param bodies names of items that agents may take, in the order in which they are given out
 * @param template what a new body is made of for an agent that gets none of those; whoever takes it
 *     renames it
 * @param places where new bodies come into the world, one each; without, where the template is
 * @param items most items that actions of one agent created
 * @param worldItems most items that actions of all agents created
 */
public record AgentPolicy(List<String> bodies, Optional<ItemDefinition> template,
        List<Place> places, int items, int worldItems) {

    /** Most items of one agent's making, unless the world file says otherwise. */
    public static final int DEFAULT_ITEMS = 1000;
    /** Most items of all agents' making, unless the world file says otherwise. */
    public static final int DEFAULT_WORLD_ITEMS = 5000;

    public AgentPolicy {
        bodies = List.copyOf(bodies);
        places = List.copyOf(places);
    }

    /** A point of the world [m]. */
    public record Place(double x, double y, double z) {}

    /** The default quotas of items. */
    public AgentPolicy(List<String> bodies, Optional<ItemDefinition> template,
            List<Place> places) {
        this(bodies, template, places, DEFAULT_ITEMS, DEFAULT_WORLD_ITEMS);
    }

    /** New bodies come to where the template is. */
    public AgentPolicy(List<String> bodies, Optional<ItemDefinition> template) {
        this(bodies, template, List.of());
    }

    /** A world without agents. */
    public static AgentPolicy none() {
        return new AgentPolicy(List.of(), Optional.empty());
    }

    /** The same with other quotas of items. */
    public AgentPolicy withItems(int ofAgent, int ofWorld) {
        return new AgentPolicy(bodies, template, places, ofAgent, ofWorld);
    }
}
