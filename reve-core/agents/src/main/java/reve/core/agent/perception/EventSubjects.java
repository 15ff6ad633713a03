// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import reve.core.world.ItemId;
import reve.core.world.WorldEvent;

import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;
import java.util.function.Function;

/**
 * The items that an event refers to, looked up once for all clients.
 *
 * @param byField the items that the event's fields name, by name of the field; the field {@value
 *     #AGENT} refers to the agent's body
 * @param items the items that the event is about; the body of its agent only if another field names
 *     it
 */
public record EventSubjects(Map<String, Mention> byField, List<Mention> items) {

    /** Name of the field that contains an agent's name. */
    public static final String AGENT = "agent";

    private static final Set<String> ITEM_FIELDS = Set.of("item", "body", "actor", "target");

    /**
     * One item that an event names.
     *
     * @param id id of the item; empty if the item no longer exists
     */
    public record Mention(String name, Optional<ItemId> id) {}

    /**
     * Returns the items that an event refers to.
     *
     * @param bodyOf returns the name of the body of an agent
     */
    public static EventSubjects in(
            WorldEvent event, Observatory world, Function<String, Optional<String>> bodyOf) {
        var byField = new HashMap<String, Mention>();
        var items = new ArrayList<Mention>(2);
        event.fields()
                .forEach(
                        (field, value) -> {
                            if (ITEM_FIELDS.contains(field)) {
                                Mention item = mention(String.valueOf(value), world);
                                byField.put(field, item);
                                items.add(item);
                            }
                        });
        Object agent = event.fields().get(AGENT);
        if (byField.containsKey("body")) {
            byField.put(AGENT, byField.get("body"));
        } else if (agent != null) {
            bodyOf.apply(String.valueOf(agent))
                    .ifPresent(name -> byField.put(AGENT, mention(name, world)));
        }
        return new EventSubjects(byField, items);
    }

    private static Mention mention(String name, Observatory world) {
        return new Mention(name, world.find(name));
    }
}
