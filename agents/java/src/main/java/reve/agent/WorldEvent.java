// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Map;

/**
 * An event of the world.
 *
 * @param fields String, Double or Boolean by name
 */
public record WorldEvent(long frame, String type, Map<String, Object> fields)
        implements ServerMessage {

    /**
     * Type of the event that replaces events that the server did not send, because the client reads
     * too slowly or other agents caused too many at once. {@code first} and {@code last} are the
     * frames of the lost events; {@code events} is their number, if the server knows it.
     */
    public static final String MISSED = "missed";
}
