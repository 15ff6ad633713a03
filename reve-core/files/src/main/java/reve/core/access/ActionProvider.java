// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Parameter;

import java.util.List;

/**
 * An action written in Java, which world files name: {@code lift: {java: NAME}}. Providers are
 * found by {@link java.util.ServiceLoader}: a jar on the class path that lists them in {@code
 * META-INF/services/reve.core.access.ActionProvider}. An object is shared by all items and worlds.
 */
public interface ActionProvider {
    /** How world files name it: {@code example.levitate}. */
    String name();

    /** One sentence for who wants to use it. */
    String doc();

    /** In the order in which they are documented; names are unique. */
    default List<Parameter> parameters() {
        return List.of();
    }

    /**
     * Decides what happens; all of it is done when it returns, or none. It may read the world, on
     * whose thread it runs, but not change it, and the same world and call must give the same
     * effects. Whatever it throws, the action is refused and nothing has happened. The frame waits
     * until it returns, and nothing ends one that does not: it never sleeps or waits.
     *
     * @throws ActionRefused if it cannot be done now
     */
    List<Effect> decide(ActionCall call) throws ActionRefused;
}
