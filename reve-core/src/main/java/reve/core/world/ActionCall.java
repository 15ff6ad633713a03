package reve.core.world;

import java.util.Optional;

/**
 * One use of an action. Valid during {@link Action#perform}, on the world's thread.
 *
 * @param frame the frame in which it happens
 * @param target the item whose action it is
 * @param actor the body that acts; empty if nobody in the world does
 * @param arguments checked against the action's parameters
 */
public record ActionCall(World world, long frame, Item target, Optional<Item> actor,
        Arguments arguments) {}
