// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.List;
import java.util.Optional;

/**
 * One call of an action. The object is valid during {@link PerformableAction#perform}, on the
 * world's thread.
 *
 * @param frame number of the frame
 * @param target the item that has the action
 * @param actor the acting body; empty if no body of this world acts
 * @param arguments checked against the action's parameters
 * @param capabilities names of the capabilities that the actor may use in this call
 * @param quota limit on the number of items that actions create
 * @param events limit on the size of the events that actions raise
 * @param forces limit on the number of forces that act in later frames
 * @param symbols limit on the bytes by which actions enlarge symbols
 */
public record ActionCall(
        World world,
        long frame,
        Item target,
        Optional<Item> actor,
        Arguments arguments,
        List<String> capabilities,
        ItemQuota quota,
        EventBudget events,
        ForceBudget forces,
        SymbolBudget symbols) {

    /** Creates a call with all capabilities of the actor, and without limits. */
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
                EventBudget.unlimited(),
                ForceBudget.unlimited(),
                new SymbolBudget(1));
    }

    /**
     * Performs an action of the target.
     *
     * @throws ActionRefused if the action is not possible now; the world is then unchanged
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
