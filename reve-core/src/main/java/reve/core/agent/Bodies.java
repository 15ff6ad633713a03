package reve.core.agent;

import java.util.HashSet;
import java.util.Optional;
import java.util.Set;
import reve.core.file.AgentPolicy;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.World;

/** Who has which body. World's thread only. */
final class Bodies {

    private final AgentPolicy policy;
    private final Set<String> taken = new HashSet<>();

    Bodies(AgentPolicy policy) {
        this.policy = policy;
    }

    /** @param made true if the item exists for this agent only and goes with it */
    record Body(ItemId id, String name, boolean made) {}

    /**
     * Gives an agent the lent item it asks for, else any free one, else a new item.
     *
     * @throws Ending if there is none for it
     */
    Body take(World world, String agent, Optional<String> wanted) throws Ending {
        if (policy.bodies().isEmpty() && policy.template().isEmpty()) {
            throw Ending.refused("no-bodies", "world " + world.name() + " grants agents no body",
                    "add `agents: {body: {...}}` or `agents: {bodies: [item, ...]}` to the world file");
        }
        if (wanted.isPresent()) {
            return lend(requireFree(world, wanted.get()));
        }
        for (String name : policy.bodies()) {
            Optional<Item> item = world.find(name);
            if (item.isPresent() && !taken.contains(name)) {
                return lend(item.get());
            }
        }
        ItemDefinition template = policy.template().orElseThrow(() -> Ending.refused("no-body-free",
                "all bodies that world " + world.name() + " lends to agents are taken",
                "try again when an agent has left"));
        return make(world, agent, template);
    }

    /** Takes a body back; it may be gone from the world already. */
    void giveBack(World world, Body body) {
        taken.remove(body.name());
        if (body.made() && world.find(body.name()).filter(item -> item.id().equals(body.id())).isPresent()) {
            world.removeCascade(body.id());
        }
    }

    private Item requireFree(World world, String name) throws Ending {
        if (!policy.bodies().contains(name)) {
            throw Ending.refused("no-such-body", "world " + world.name() + " lends agents no item "
                    + Text.quote(name), "it lends " + policy.bodies());
        }
        if (taken.contains(name)) {
            throw Ending.refused("body-taken", "another agent has the body " + Text.quote(name),
                    "leave out body to get any that is free");
        }
        return world.find(name).orElseThrow(() -> Ending.refused("no-such-body",
                "the item " + Text.quote(name) + " is no longer in world " + world.name(),
                "leave out body to get any that is free"));
    }

    private Body lend(Item item) {
        taken.add(item.name());
        return new Body(item.id(), item.name(), false);
    }

    private static Body make(World world, String agent, ItemDefinition template) throws Ending {
        if (world.find(agent).isPresent()) {
            throw Ending.refused("name-taken", "world " + world.name() + " has an item " + Text.quote(agent)
                    + " already, so the agent's body cannot be called that", "say hello with another name");
        }
        Item item = world.add(template.renamed(agent));
        return new Body(item.id(), item.name(), true);
    }
}
