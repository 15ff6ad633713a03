// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * The effects on other items of removing an agent's body from the world. The removal is never
 * refused.
 *
 * @param detached names of the items that were attached to the body and are now detached, in the
 *     order of their ids
 * @param removed names of the items that were removed because they referred to the body, directly
 *     or through other items
 */
public record Departure(List<String> detached, List<String> removed) {

    /**
     * Removes an item. Items that are attached to it are detached first and keep their pose in the
     * world. Items that refer to the removed item are also removed, and items that are attached to
     * those are detached.
     *
     * @throws IllegalArgumentException if it is the item {@code world}
     * @throws IllegalStateException naming the phase of the frame if it permits no removal
     */
    public static Departure of(World world, ItemId id) {
        List<Item> referring = world.referring(id);
        Set<ItemId> going = new HashSet<>(referring.stream().map(Item::id).toList());
        going.add(id);
        List<ItemId> staying =
                going.stream()
                        .flatMap(item -> world.item(item).children().stream())
                        .filter(child -> !going.contains(child))
                        .sorted()
                        .toList();
        var departure =
                new Departure(
                        staying.stream().map(item -> world.item(item).name()).toList(),
                        referring.stream().map(Item::name).toList());
        staying.forEach(world::detach);
        world.removeCascade(id);
        return departure;
    }

    /**
     * Raises an event {@code detached} or {@code removed} for each affected item.
     *
     * @param agent name of the agent whose body left
     * @param body name of the body
     */
    public void raise(World world, long frame, String agent, String body) {
        raise(world, frame, "detached", detached, agent, body);
        raise(world, frame, "removed", removed, agent, body);
    }

    private static void raise(
            World world, long frame, String type, List<String> items, String agent, String body) {
        for (String item : items) {
            Map<String, Object> fields = new LinkedHashMap<>();
            fields.put("agent", agent);
            fields.put("body", body);
            fields.put("item", item);
            world.raise(new WorldEvent(frame, type, fields));
        }
    }
}
