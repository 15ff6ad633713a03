// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.nio.DoubleBuffer;
import java.util.Collections;
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
 * @param time time of the world [s]
 * @param results in lock-step, the results of the previous round's acts, in order
 * @param readings the newest readings of the instruments of the agent's body, by the name of the
 *     sensor
 * @param heard the texts that the agent has heard since the previous perception, in order; at most
 *     the last {@value AgentClient#MAX_EVENTS}
 */
public record Perception(
        OptionalLong id,
        long frame,
        double time,
        List<Item> items,
        List<ActResult> results,
        Map<String, Reading> readings,
        List<Heard> heard)
        implements ServerMessage {

    Perception(
            OptionalLong id,
            long frame,
            double time,
            List<Item> items,
            Map<String, Reading> readings) {
        this(id, frame, time, items, List.of(), readings, List.of());
    }

    Perception with(List<ActResult> ofActs) {
        return new Perception(id, frame, time, items, ofActs, readings, heard);
    }

    Perception withHeard(List<Heard> voices) {
        return new Perception(id, frame, time, items, results, readings, voices);
    }

    /** Returns the item of that name, if it was perceived. */
    public Optional<Item> find(String name) {
        return items.stream().filter(item -> item.name().equals(name)).findFirst();
    }

    /**
     * Returns this perception after an update.
     *
     * @throws AgentException if the update is relative to another perception
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
        var newest = new LinkedHashMap<>(readings);
        newest.putAll(update.readings());
        return new Perception(
                update.id(),
                update.frame(),
                update.time(),
                List.copyOf(known.values()),
                Collections.unmodifiableMap(newest));
    }

    /**
     * The numbers that an instrument of the agent's body measured in a frame. Buffers are
     * read-only.
     *
     * <p>An {@code imu} measures in the body's own axes: {@code specificForce}, 3 numbers [m/s²],
     * the acceleration minus gravity, and {@code angularVelocity}, 3 numbers [rad/s]. A {@code
     * lidar} measures {@code distances} [m], row by row, which are infinite for rays that met
     * nothing. A sensor of the {@code contactForce} measures {@code force}, 3 numbers [N].
     *
     * @param frame the frame of the measurement
     * @param quantities the measured numbers, by the name of the quantity
     * @param columns number of rays side by side, for a lidar only
     */
    public record Reading(long frame, Map<String, DoubleBuffer> quantities, OptionalInt columns) {

        /**
         * Returns a measured quantity.
         *
         * @throws IllegalArgumentException if the instrument does not measure it
         */
        public DoubleBuffer numbers(String quantity) {
            DoubleBuffer numbers = quantities.get(quantity);
            if (numbers == null) {
                throw new IllegalArgumentException(
                        "the instrument does not measure "
                                + quantity
                                + "; it measures "
                                + quantities.keySet());
            }
            return numbers.duplicate();
        }
    }

    /**
     * One perceived item.
     *
     * @param location location in the world's reference frame [m]; empty if the item has no
     *     location or no sensor reaches it
     * @param orientation orientation in the world's reference frame
     * @param symbols named facts about the item: String, Double, Boolean or a List of these
     * @param actions the parameters of each action, by name
     * @param needs the capabilities that each action requires of the acting body; omits actions
     *     that require none
     * @param capabilities capabilities of the item itself
     */
    public record Item(
            String name,
            Optional<Location> location,
            Orientation orientation,
            Map<String, Object> symbols,
            Map<String, Map<String, Parameter>> actions,
            Map<String, List<String>> needs,
            List<String> capabilities) {

        /**
         * Returns whether the item belongs to a class: its own class, or one above it. Returns
         * false if no sensor perceives the symbols {@code class} and {@code classes}.
         */
        public boolean isA(String itemClass) {
            return itemClass.equals(symbols.get("class"))
                    || symbols.get("classes") instanceof List<?> classes
                            && classes.contains(itemClass);
        }
    }

    /** A location in the world's reference frame [m], +Y up. */
    public record Location(double x, double y, double z) {}

    /** A rotation as a unit quaternion. */
    public record Orientation(double x, double y, double z, double w) {

        /** The value for no rotation. */
        public static final Orientation NONE = new Orientation(0, 0, 0, 1);
    }

    /**
     * One parameter of an action.
     *
     * @param type "number", "text", "truth" or "item"
     * @param components number of components, for numbers only
     * @param unit unit of the numbers, for numbers only
     * @param min minimum of each component, if there is one
     * @param max maximum of each component, if there is one
     */
    public record Parameter(
            String type,
            OptionalInt components,
            Optional<String> unit,
            OptionalDouble min,
            OptionalDouble max) {}
}
