// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.ItemDefinition;

import java.util.List;
import java.util.Optional;

/**
 * Which bodies a world grants to agents, none unless the world file says so; how many agents may be
 * in it; how many items their actions may have in it at a time; and how many bytes of events they
 * may raise.
 *
 * @param bodies names of items that agents may take, in the order in which they are given out
 * @param template what a new body is made of for an agent that gets none of those; whoever takes it
 *     renames it
 * @param places where new bodies come into the world, one each; without, where the template is
 * @param items most items that actions of one agent created
 * @param worldItems most items that actions of all agents created
 * @param eventBytes most bytes of events in a second of world time that actions of one agent raise
 * @param worldEventBytes most bytes of events in a second of world time that actions of all agents
 *     raise
 * @param most most agents, those included whose connection broke and who may come back; never fewer
 *     than bodies
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

    /** Most items of one agent's making, unless the world file says otherwise. */
    public static final int DEFAULT_ITEMS = 1000;

    /** Most items of all agents' making, unless the world file says otherwise. */
    public static final int DEFAULT_WORLD_ITEMS = 5000;

    /** Most agents, unless the world file says otherwise. */
    public static final int DEFAULT_MOST = 256;

    /** Most bytes of events in a second of one agent's, unless the world file says otherwise. */
    public static final int DEFAULT_EVENT_BYTES = 16 * 1024;

    /** Most bytes of events in a second of all agents', unless the world file says otherwise. */
    public static final int DEFAULT_WORLD_EVENT_BYTES = 256 * 1024;

    public AgentPolicy {
        bodies = List.copyOf(bodies);
        places = List.copyOf(places);
    }

    /** A point of the world [m]. */
    public record Place(double x, double y, double z) {}

    /** The default quotas. */
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
        return new AgentPolicy(
                bodies, template, places, ofAgent, ofWorld, eventBytes, worldEventBytes, most);
    }

    /** The same with other budgets of events [byte/s]. */
    public AgentPolicy withEvents(int ofAgent, int ofWorld) {
        return new AgentPolicy(bodies, template, places, items, worldItems, ofAgent, ofWorld, most);
    }

    /** The same without the bodies that are not named. */
    public AgentPolicy withBodies(List<String> remaining) {
        return new AgentPolicy(
                remaining, template, places, items, worldItems, eventBytes, worldEventBytes, most);
    }

    /** The same with another quota of agents. */
    public AgentPolicy withMost(int agents) {
        return new AgentPolicy(
                bodies, template, places, items, worldItems, eventBytes, worldEventBytes, agents);
    }
}
