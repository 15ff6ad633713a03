// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.embodiment;

import reve.core.agent.auth.Rights;
import reve.core.agent.perception.SensedWorld;
import reve.core.world.Item;
import reve.core.world.ItemId;
import reve.core.world.Sensor;
import reve.core.world.World;

import java.util.List;
import java.util.Optional;
import java.util.OptionalInt;

/**
 * The body of an agent. Immutable.
 *
 * @param name the name of the body when the agent joined
 * @param made true if the item was created for this agent and is removed when the agent leaves
 * @param place index of the place in {@link reve.core.file.AgentPolicy} at which the body was
 *     created; empty if the body was not created at such a place
 * @param sensors sensors of the body; if empty, the agent perceives everything
 * @param ofActions the sensors among them that perceive the actions of items
 * @param needsSight true if one of the sensors needs a line of sight
 * @param ears largest range of its hearing sensors [m], negative if it has none
 * @param rights rights of the agent
 */
record Body(
        ItemId id,
        String name,
        boolean made,
        OptionalInt place,
        List<Sensor> sensors,
        List<Sensor> ofActions,
        boolean needsSight,
        double ears,
        Rights rights) {

    Body(
            ItemId id,
            String name,
            boolean made,
            OptionalInt place,
            List<Sensor> sensors,
            Rights rights) {
        this(
                id,
                name,
                made,
                place,
                sensors,
                sensors.stream()
                        .filter(sensor -> sensor.aspects().contains(Sensor.Aspect.ACCESS))
                        .toList(),
                sensors.stream().anyMatch(Sensor::lineOfSight),
                sensors.stream()
                        .filter(Sensor::hearing)
                        .mapToDouble(Sensor::range)
                        .max()
                        .orElse(-1),
                rights);
    }

    Optional<Item> in(World world) {
        return world.find(id);
    }

    /** Returns the item's capabilities that the agent may use. */
    List<String> capabilities(Item item) {
        List<String> all = item.access().capabilities();
        return rights.capabilities().isEmpty()
                ? all
                : all.stream().filter(rights::opensCapability).toList();
    }

    /**
     * Returns whether one of these sensors of the body senses an item.
     *
     * @param sensed data that contains the bodies in both rows; it contains all bodies if {@link
     *     #needsSight} is true
     * @param eye row of this body; negative if it has none
     * @param row row of the item; negative if it has none
     */
    static boolean senses(SensedWorld sensed, List<Sensor> sensors, int eye, int row) {
        for (Sensor sensor : sensors) {
            if (sensor.isUnlimited() || eye >= 0 && row >= 0 && sensed.senses(sensor, eye, row)) {
                return true;
            }
        }
        return false;
    }
}
