// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.util.Map;

/**
 * A listener for events of a server. It is called on the threads of the worlds and of the renderer,
 * and must not block.
 */
@FunctionalInterface
public interface ServerEvents {
    /**
     * Receives an event.
     *
     * @param event {@code ready}, {@code picture}, {@code end}, or the type of a world event
     * @param fields text, numbers, booleans, or lists of these, by name, in order; the caller does
     *     not change them afterwards
     */
    void happened(String event, Map<String, Object> fields);

    /** Returns whether {@link #happened} receives world events of a type. For any thread. */
    default boolean wants(String event) {
        return true;
    }
}
