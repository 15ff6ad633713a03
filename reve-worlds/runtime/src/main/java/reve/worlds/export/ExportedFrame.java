// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import reve.core.world.WorldSnapshot;

import java.util.List;
import java.util.Map;

/**
 * A frame that an export receives.
 *
 * @param snapshot the state at the end of the frame; the caller closes it
 * @param events the events of the frame, in order
 */
public record ExportedFrame(WorldSnapshot snapshot, List<Event> events) {
    /**
     * An event of a frame.
     *
     * @param fields text, numbers and truth values by name, in the order of the event
     */
    public record Event(String type, Map<String, Object> fields) {}
}
