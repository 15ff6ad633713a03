// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.Map;

/**
 * The answer to a query about the world, see agents/protocol/PROTOCOL.md.
 *
 * @param id id of the query
 * @param of type of the query
 * @param content String, Number, Boolean, or a List or Map of these, by name
 */
public record Report(long id, long frame, String of, Map<String, Object> content)
        implements ServerMessage {
    /** Copies the map. */
    public Report {
        content = Collections.unmodifiableMap(new LinkedHashMap<>(content));
    }
}
