// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalDouble;
import java.util.OptionalInt;
import java.util.OptionalLong;

/**
 * All items that an agent perceives in one frame.
 *
 * @param time of the world [s]
 * @param results in lock-step those of what was done in the round before, in order
 */
public record Perception(
        OptionalLong id, long frame, double time, List<Item> items, List<ActResult> results)
        implements ServerMessage {

    Perception(OptionalLong id, long frame, double time, List<Item> items) {
        this(id, frame, time, items, List.of());
    }

    Perception with(List<ActResult> ofActs) {
        return new Perception(id, frame, time, items, ofActs);
    }

    /** The item of that name, if it was perceived. */
    public Optional<Item> find(String name) {
        return items.stream().filter(item -> item.name().equals(name)).findFirst();
    }

    /**
     * What the agent perceives after an update to this perception.
     *
     * @throws AgentException if the update is to another one
     */
    Perception updated(Update update) {
        if (update.since() != frame) {
            throw new AgentException(
                    "protocol",
                    "an update to frame " + update.since() + " came after frame " + frame,
                    Optional.empty());
        }
        var known = new LinkedHashMap<String, Item>();
        items.forEach(item -> known.put(item.name(), item));
        update.left().forEach(known::remove);
        update.entered().forEach(item -> known.put(item.name(), item));
        for (Update.Change change : update.changed()) {
            Item changed =
                    known.computeIfPresent(change.name(), (name, item) -> change.applyTo(item));
            if (changed == null) {
                throw new AgentException(
                        "protocol",
                        change.name() + " changed, which the agent does not perceive",
                        Optional.empty());
            }
        }
        return new Perception(
                update.id(), update.frame(), update.time(), List.copyOf(known.values()));
    }

    /**
     * One item as perceived.
     *
     * @param location in the world's frame [m]; empty for what has no place or one that is not
     *     sensed
     * @param orientation in the world's frame
     * @param symbols String, Double, Boolean or a List of these by name
     * @param actions by name: parameters by name
     * @param needs capabilities that the body of who acts must have, by action; those that need
     *     none are left out
     * @param capabilities the item's own
     */
    public record Item(
            String name,
            Optional<Location> location,
            Orientation orientation,
            Map<String, Object> symbols,
            Map<String, Map<String, Parameter>> actions,
            Map<String, List<String>> needs,
            List<String> capabilities) {}

    /** A place in the world's frame [m], +Y up. */
    public record Location(double x, double y, double z) {}

    /** A rotation as a unit quaternion. */
    public record Orientation(double x, double y, double z, double w) {

        /** No rotation. */
        public static final Orientation NONE = new Orientation(0, 0, 0, 1);
    }

    /**
     * What an action takes.
     *
     * @param type "number", "text", "truth" or "item"
     * @param components how many numbers, for numbers only
     * @param unit that they are in, for numbers only
     * @param min least value of each of them, if there is a bound
     * @param max greatest value of each of them, if there is a bound
     */
    public record Parameter(
            String type,
            OptionalInt components,
            Optional<String> unit,
            OptionalDouble min,
            OptionalDouble max) {}
}
