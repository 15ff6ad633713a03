// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.protocol;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Optional;

/**
 * A request of an agent to perform an action of an item, as the message contains it.
 *
 * @param item the item with the action; empty for the agent's own body
 * @param arguments Double, List of Double, String or Boolean by parameter name, not checked yet
 */
public record ActionRequest(Optional<String> item, String action, Map<String, Object> arguments) {
    /** Copies the arguments. */
    public ActionRequest {
        arguments = Collections.unmodifiableMap(new LinkedHashMap<>(arguments));
    }
}
