// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Map;
import java.util.Optional;

/**
 * An action of an item, with its arguments.
 *
 * @param item name of the item; empty for the agent's own body
 * @param arguments by parameter name: a Number, a double[] or List of Numbers, a String or a
 *     Boolean, in the units that the action declares
 */
public record Act(Optional<String> item, String action, Map<String, ?> arguments) {

    /** Copies the arguments. */
    public Act {
        arguments = Map.copyOf(arguments);
    }

    /** Returns an action of an item with arguments. */
    public static Act of(String item, String action, Map<String, ?> arguments) {
        return new Act(Optional.of(item), action, arguments);
    }

    /** Returns the act with which the agent says a text, see {@link AgentClient#say}. */
    public static Act say(String text) {
        return ofBody(Protocol.SAY, Map.of("text", text));
    }

    /** Returns an action of the agent's own body. */
    public static Act ofBody(String action, Map<String, ?> arguments) {
        return new Act(Optional.empty(), action, arguments);
    }
}
