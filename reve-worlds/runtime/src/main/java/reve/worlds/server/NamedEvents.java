// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.util.LinkedHashMap;
import java.util.Map;

/** A listener that adds the name of the world to each event. */
record NamedEvents(String world, ServerEvents events) implements ServerEvents {
    @Override
    public void happened(String event, Map<String, Object> fields) {
        Map<String, Object> all = new LinkedHashMap<>();
        all.put("world", world);
        fields.forEach(all::putIfAbsent); // an event cannot replace the name
        events.happened(event, all);
    }

    @Override
    public boolean wants(String event) {
        return events.wants(event);
    }
}
