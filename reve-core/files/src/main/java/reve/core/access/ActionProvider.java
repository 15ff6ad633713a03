// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;

import java.util.List;

/**
 * An action written in Java. World files refer to it by name: {@code lift: {java: NAME}}. A plugin
 * lists its providers in {@code META-INF/services/reve.core.access.ActionProvider}. All items and
 * worlds of a process share one instance of a plugin. Each world calls it on its own thread,
 * possibly at the same time, so an instance must not store data of a world.
 */
public interface ActionProvider {
    /**
     * Returns the name by which world files refer to the action, for example {@code
     * example.levitate}.
     */
    String name();

    /** Returns one sentence that describes the action to its callers. */
    String doc();

    /** Returns the parameters in the order in which they are documented. Their names are unique. */
    default List<Parameter> parameters() {
        return List.of();
    }

    /**
     * Decides the effects of a call. The world applies either all of these effects or none after
     * this method has returned. Runs on the world's thread.
     *
     * <p>The method may read the world, but must not change it. It must return the same effects for
     * the same world and call. Any exception refuses the action, and the world stays unchanged. The
     * frame waits for the method without a time limit, so the method must not sleep or block.
     *
     * @throws ActionRefused if the action is not possible now
     */
    List<Effect> decide(ActionCall call) throws ActionRefused;
}
