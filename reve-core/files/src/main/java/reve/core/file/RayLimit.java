// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.Instrument.Lidar;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;

import java.util.HashMap;
import java.util.HashSet;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** The limit on the rays that the lidars of all bodies of agents cast in a frame. */
public final class RayLimit {
    private final Problems problems;

    RayLimit(Problems problems) {
        this.problems = problems;
    }

    /**
     * Records a problem if the bodies would cast too many rays with as many agents as the world
     * admits.
     */
    void check(Node node, AgentPolicy agents, List<ItemDefinition> items) {
        Set<String> lent = new HashSet<>(agents.bodies());
        Map<String, List<Sensor>> sensors = new HashMap<>();
        for (ItemDefinition item : items) {
            if (lent.contains(item.name())) {
                sensors.put(item.name(), item.sensors());
            }
        }
        excess(agents, sensors)
                .ifPresent(
                        found ->
                                problems.addAtKey(
                                        node,
                                        "agents: "
                                                + found
                                                + (agents.template().isEmpty()
                                                        ? ""
                                                        : " (`most`, `places`)")));
    }

    /**
     * Returns a message if the bodies cast too many rays.
     *
     * @param sensors the sensors of the bodies that the world offers to agents, by name
     */
    public static Optional<String> excess(AgentPolicy agents, Map<String, List<Sensor>> sensors) {
        long rays = sensors.values().stream().mapToLong(RayLimit::rays).sum();
        long made = agents.places().isEmpty() ? agents.most() : agents.places().size();
        made = Math.min(made, agents.most());
        rays += agents.template().map(body -> rays(body.sensors())).orElse(0L) * made;
        return rays <= Lidar.MAX_WORLD_RAYS
                ? Optional.empty()
                : Optional.of(
                        "the lidars of all bodies cast "
                                + rays
                                + " rays in a frame, expected at most "
                                + Lidar.MAX_WORLD_RAYS
                                + "; use fewer `rays`, a greater `every`, or fewer bodies");
    }

    private static long rays(List<Sensor> sensors) {
        long rays = 0;
        for (Sensor sensor : sensors) {
            if (sensor.instrument().orElse(null) instanceof Lidar lidar) {
                rays += Math.ceilDiv(lidar.rays(), sensor.every());
            }
        }
        return rays;
    }
}
