// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;

import java.util.List;
import java.util.Optional;

/**
 * The bodies that a world grants to agents. It also limits the number of agents, and the items and
 * events that their actions create. A world file without a declaration grants no bodies.
 *
 * @param bodies names of items that agents may take, in the order of assignment
 * @param template definition of a new body for an agent that gets none of {@code bodies}; the
 *     caller renames it
 * @param places places for new bodies, each for one body; if empty, new bodies get the template's
 *     place
 * @param items maximum number of existing items that actions of one agent created
 * @param worldItems maximum number of existing items that actions of all agents created
 * @param eventBytes maximum size of events that actions of one agent raise [byte/s of world time]
 * @param worldEventBytes maximum size of events that actions of all agents raise [byte/s of world
 *     time]
 * @param most maximum number of agents, including disconnected agents that may reconnect; never
 *     less than the number of bodies
 */
public record AgentPolicy(
        List<String> bodies,
        Optional<ItemDefinition> template,
        List<Place> places,
        int items,
        int worldItems,
        int eventBytes,
        int worldEventBytes,
        int most) {

    /** Default maximum number of items that one agent creates. */
    public static final int DEFAULT_ITEMS = 200;

    /** Default maximum number of items that all agents create. */
    public static final int DEFAULT_WORLD_ITEMS = 1000;

    /** Default maximum number of agents. */
    public static final int DEFAULT_MOST = 256;

    /** Default maximum size of one agent's events [byte/s of world time]. */
    public static final int DEFAULT_EVENT_BYTES = 16 * 1024;

    /** Default maximum size of all agents' events [byte/s of world time]. */
    public static final int DEFAULT_WORLD_EVENT_BYTES = 256 * 1024;

    /** Copies the lists. */
    public AgentPolicy {
        bodies = List.copyOf(bodies);
        places = List.copyOf(places);
    }

    /** A point of the world [m]. */
    public record Place(double x, double y, double z) {}

    /** Creates a policy with the default limits. */
    public AgentPolicy(List<String> bodies, Optional<ItemDefinition> template, List<Place> places) {
        this(
                bodies,
                template,
                places,
                DEFAULT_ITEMS,
                DEFAULT_WORLD_ITEMS,
                DEFAULT_EVENT_BYTES,
                DEFAULT_WORLD_EVENT_BYTES,
                DEFAULT_MOST);
    }

    /** Creates a policy with the default limits. New bodies are created at the template's place. */
    public AgentPolicy(List<String> bodies, Optional<ItemDefinition> template) {
        this(bodies, template, List.of());
    }

    /** Returns a policy that grants no bodies, so that no agent can join. */
    public static AgentPolicy none() {
        return new AgentPolicy(List.of(), Optional.empty());
    }

    /** Returns this policy with other limits on created items. */
    public AgentPolicy withItems(int ofAgent, int ofWorld) {
        return new AgentPolicy(
                bodies, template, places, ofAgent, ofWorld, eventBytes, worldEventBytes, most);
    }

    /** Returns this policy with other limits on events [byte/s of world time]. */
    public AgentPolicy withEvents(int ofAgent, int ofWorld) {
        return new AgentPolicy(bodies, template, places, items, worldItems, ofAgent, ofWorld, most);
    }

    /** Returns this policy with these bodies instead of its own. */
    public AgentPolicy withBodies(List<String> remaining) {
        return new AgentPolicy(
                remaining, template, places, items, worldItems, eventBytes, worldEventBytes, most);
    }

    /** Returns this policy with another maximum number of agents. */
    public AgentPolicy withMost(int agents) {
        return new AgentPolicy(
                bodies, template, places, items, worldItems, eventBytes, worldEventBytes, agents);
    }
}
