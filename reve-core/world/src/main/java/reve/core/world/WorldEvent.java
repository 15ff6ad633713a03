// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.nio.charset.StandardCharsets;
import java.util.Collections;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;

/**
 * An event of a frame. Agents, operators and the journal receive it.
 *
 * @param type joined, left, acted, law-loaded, law-unloaded, fault, or the type of an action's
 *     event
 * @param fields values by name, in the order given: String, Number or Boolean
 */
public record WorldEvent(long frame, String type, Map<String, Object> fields) {
    /**
     * Types of events that the server itself raises, sends or prints. Actions and plugins must not
     * raise them.
     */
    public static final List<String> OF_THE_SERVER =
            List.of(
                    "joined",
                    "left",
                    "acted",
                    "law-loaded",
                    "law-unloaded",
                    "law-shadow",
                    "fault",
                    "over-budget",
                    "missed",
                    "waiting",
                    "ready",
                    "standby",
                    "cluster",
                    "picture",
                    "picture-failed",
                    "saved",
                    "rewound",
                    "stalled",
                    "recovered",
                    "late",
                    "away",
                    "back",
                    "end",
                    "detached",
                    "removed",
                    "spoke",
                    "heard",
                    "world-asleep",
                    "watching",
                    LevelChange.EVENT);

    /** Checks the type, and copies the fields in their order. */
    public WorldEvent {
        Names.require("event type", type);
        fields = Collections.unmodifiableMap(new LinkedHashMap<>(fields));
        fields.forEach(
                (name, value) -> {
                    if (!(value instanceof String
                            || value instanceof Number
                            || value instanceof Boolean)) {
                        throw new IllegalArgumentException(
                                "event field "
                                        + name
                                        + " is "
                                        + value
                                        + ", expected text, a number or truth");
                    }
                });
    }

    /**
     * Returns the size of the event [bytes]. It is the sum of the type, names and texts in UTF-8,
     * and 8 bytes for each number or truth value.
     */
    public long bytes() {
        long bytes = utf8(type);
        for (Map.Entry<String, Object> field : fields.entrySet()) {
            bytes += utf8(field.getKey());
            bytes += field.getValue() instanceof String text ? utf8(text) : Double.BYTES;
        }
        return bytes;
    }

    private static int utf8(String text) {
        return text.getBytes(StandardCharsets.UTF_8).length;
    }
}
