// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.Map;

/**
 * Something that happened in the world.
 *
 * @param fields String, Double or Boolean by name
 */
public record WorldEvent(long frame, String type, Map<String, Object> fields)
        implements ServerMessage {

    /**
     * The type of an event that stands for others: those of the frames {@code first} to {@code
     * last}, which the server did not send, as the client reads too slowly or others caused too
     * many at once; {@code events} are how many, if the server knows.
     */
    public static final String MISSED = "missed";
}
