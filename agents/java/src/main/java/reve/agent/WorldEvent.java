package reve.agent;

import java.util.Map;

/**
 * Something that happened in the world.
 *
 * @param fields String, Double or Boolean by name
 */
public record WorldEvent(long frame, String type, Map<String, Object> fields)
        implements ServerMessage {}
