// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.session;

import reve.core.agent.protocol.BadMessage;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Text;
import reve.core.world.ItemId;
import reve.core.world.ItemSymbols;
import reve.core.world.Sensor;
import reve.core.world.SnapshotRing;
import reve.core.world.WorldSnapshot;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.stream.Collectors;

/**
 * A camera of any body of a world.
 *
 * @param body the item that carries the camera
 */
record BodyCamera(ItemId body, Sensor camera) {

    /**
     * Finds the camera that a message names, in the newest frame. Visits all items, so the caller
     * must not be the event loop's thread. For any other thread.
     *
     * @throws BadMessage if the world has no such item, or the item no such camera
     */
    static BodyCamera find(SnapshotRing snapshots, ClientMessage.Look look, String name)
            throws BadMessage {
        Optional<WorldSnapshot> newest = snapshots.acquireLatest();
        if (newest.isEmpty()) {
            throw new BadMessage(
                    look.id(), "no-picture", "the world has made no frame yet", "try again");
        }
        try (WorldSnapshot snapshot = newest.get()) {
            for (ItemSymbols item : snapshot.symbols().values()) {
                if (item.name().equals(name)) {
                    return new BodyCamera(item.id(), camera(item, look));
                }
            }
        }
        throw new BadMessage(
                look.id(),
                "no-such-camera",
                "the world has no item " + Text.quote(name),
                "the report state lists the bodies of agents and their cameras");
    }

    private static Sensor camera(ItemSymbols item, ClientMessage.Look look) throws BadMessage {
        for (Sensor sensor : item.sensors()) {
            if (sensor.isCamera() && sensor.name().equals(look.sensor())) {
                return sensor;
            }
        }
        throw new BadMessage(
                look.id(),
                "no-such-camera",
                "the item "
                        + Text.quote(item.name())
                        + " has no camera "
                        + Text.quote(look.sensor()),
                hint(names(item.sensors())));
    }

    /** Returns the names of the cameras among a body's sensors. */
    static List<String> names(Iterable<Sensor> sensors) {
        var names = new ArrayList<String>();
        sensors.forEach(
                sensor -> {
                    if (sensor.isCamera()) {
                        names.add(sensor.name());
                    }
                });
        return List.copyOf(names);
    }

    /** Returns the hint of a refusal, which lists the cameras that the body has. */
    static String hint(List<String> names) {
        return names.isEmpty()
                ? "it has no camera; the world file says which sensors a body has"
                : "its cameras are "
                        + names.stream().map(Text::quote).collect(Collectors.joining(", "));
    }
}
