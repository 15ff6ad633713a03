// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.util.Map;

/**
 * Hears what happens in a server. Called from the world's and the renderer's thread; must not
 * block.
 */
@FunctionalInterface
public interface ServerEvents {
    /**
     * @param event {@code ready}, {@code snapshot}, {@code end}, or the type of a world event
     * @param fields text, numbers, truth, or lists of these, by name, in order; not changed after
     */
    void happened(String event, Map<String, Object> fields);

    /** Whether {@link #happened} is to be told of world events of a type; any thread. */
    default boolean wants(String event) {
        return true;
    }
}
