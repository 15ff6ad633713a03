package reve.agent;

import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalInt;
import java.util.OptionalLong;

/**
 * All items of one frame.
 *
 * @param time of the world [s]
 */
public record Perception(OptionalLong id, long frame, double time, List<Item> items) implements ServerMessage {

    /** The item of that name, if it was perceived. */
    public Optional<Item> find(String name) {
        return items.stream().filter(item -> item.name().equals(name)).findFirst();
    }

    /**
     * One item as perceived.
     *
     * @param location in the world's frame [m]; empty for what has no place
     * @param symbols String, Double, Boolean or a List of these by name
     * @param actions by name: parameters by name
     */
    public record Item(String name, Optional<Location> location, Map<String, Object> symbols,
            Map<String, Map<String, Parameter>> actions) {}

    /** A place in the world's frame [m], +Y up. */
    public record Location(double x, double y, double z) {}

    /**
     * What an action takes.
     *
     * @param type "number", "text" or "truth"
     * @param components how many numbers, for numbers only
     * @param unit that they are in, for numbers only
     */
    public record Parameter(String type, OptionalInt components, Optional<String> unit) {}
}
