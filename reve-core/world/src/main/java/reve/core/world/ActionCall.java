// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * One use of an action. Valid during {@link PerformableAction#perform}, on the world's thread.
 *
 * @param frame the frame in which it happens
 * @param target the item whose action it is
 * @param actor the body that acts; empty if nobody in the world does
 * @param arguments checked against the action's parameters
 * @param capabilities those of the actor that it may use now
 * @param quota how many items it may create
 * @param events how many bytes of events it may raise
 */
public record ActionCall(
        World world,
        long frame,
        Item target,
        Optional<Item> actor,
        Arguments arguments,
        List<String> capabilities,
        ItemQuota quota,
        EventBudget events) {

    /** With all capabilities that the actor has, and no limits. */
    public ActionCall(
            World world, long frame, Item target, Optional<Item> actor, Arguments arguments) {
        this(
                world,
                frame,
                target,
                actor,
                arguments,
                actor.map(item -> item.access().capabilities()).orElse(List.of()),
                ItemQuota.NONE,
                EventBudget.unlimited());
    }

    /**
     * Performs an action of the target.
     *
     * @throws ActionRefused if it cannot be done now; nothing has happened then
     */
    public void perform(Action action) throws ActionRefused {
        if (!(action instanceof PerformableAction performable)) {
            throw new IllegalStateException(
                    "action "
                            + action.name()
                            + " of "
                            + target
                            + " is a "
                            + action.getClass().getName()
                            + ", expected a PerformableAction");
        }
        performable.perform(this);
    }
}
