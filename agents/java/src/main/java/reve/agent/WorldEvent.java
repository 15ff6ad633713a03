// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Map;

/**
 * An event of the world.
 *
 * @param fields values by name: String, Double, Boolean or a List of these
 */
public record WorldEvent(long frame, String type, Map<String, Object> fields)
        implements ServerMessage {

    /**
     * Type of the event that replaces events that the server did not send. The reason is that the
     * client reads too slowly, or that other agents caused too many events at once. The fields
     * {@code first} and {@code last} are the frames of the lost events. The field {@code events} is
     * their number, if the server knows it.
     */
    public static final String MISSED = "missed";
}
