// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.OptionalLong;

/**
 * The differences from an earlier perception; {@link AgentClient} applies them.
 *
 * @param time time of the world [s]
 * @param since frame of the earlier perception
 * @param left names of items of the earlier perception that this one does not contain
 * @param readings readings that are newer than the earlier perception, by the name of the sensor
 */
record Update(
        OptionalLong id,
        long frame,
        double time,
        long since,
        List<String> left,
        List<Perception.Item> entered,
        List<Change> changed,
        Map<String, Perception.Reading> readings)
        implements ServerMessage {

    /** The changed data of an item; a field that did not change is empty. */
    record Change(
            String name,
            Optional<Perception.Location> location,
            Optional<Perception.Orientation> orientation,
            Optional<Map<String, Object>> symbols,
            Optional<Map<String, Map<String, Perception.Parameter>>> actions,
            Optional<Map<String, List<String>>> needs) {

        Perception.Item applyTo(Perception.Item item) {
            return new Perception.Item(
                    name,
                    location.or(item::location),
                    orientation.orElse(item.orientation()),
                    symbols.orElse(item.symbols()),
                    actions.orElse(item.actions()),
                    needs.orElse(item.needs()),
                    item.capabilities());
        }
    }
}
