// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;

/**
 * What became of other items when an item left the world that cannot be refused to leave: the body
 * of an agent.
 *
 * @param detached names of the items that were attached and are on their own now, in the order of
 *     their ids
 * @param removed names of the items that referred to it, directly or not, and are gone with it
 */
public record Departure(List<String> detached, List<String> removed) {

    /**
     * Removes an item. What is attached to it is detached first and stays where it is now. Items
     * that refer to it cannot be without it, and are removed; what is attached to those is
     * detached, too.
     *
     * @throws IllegalArgumentException if it is the item {@code world}
     * @throws IllegalStateException naming the phase if the structure is locked
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
     * Raises an event {@code detached} or {@code removed} for each of those items.
     *
     * @param agent whose body left
     * @param body its name
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
