// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import reve.core.world.Instrument.Lidar;
import reve.core.world.ItemDefinition;
import reve.core.world.Sensor;

import java.util.HashSet;
import java.util.List;
import java.util.Set;

/** The limit on the rays that the lidars of all bodies of agents cast in a frame. */
final class RayLimit {
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
        long rays = 0;
        for (ItemDefinition item : items) {
            if (lent.contains(item.name())) {
                rays += rays(item);
            }
        }
        long made = agents.places().isEmpty() ? agents.most() : agents.places().size();
        made = Math.min(made, agents.most());
        rays += agents.template().map(RayLimit::rays).orElse(0L) * made;
        if (rays > Lidar.MAX_WORLD_RAYS) {
            problems.addAtKey(
                    node,
                    "agents: the lidars of all bodies cast "
                            + rays
                            + " rays in a frame, expected at most "
                            + Lidar.MAX_WORLD_RAYS
                            + "; use fewer `rays`, a greater `every`, or fewer bodies"
                            + (agents.template().isEmpty() ? "" : " (`most`, `places`)"));
        }
    }

    private static long rays(ItemDefinition item) {
        long rays = 0;
        for (Sensor sensor : item.sensors()) {
            if (sensor.instrument().orElse(null) instanceof Lidar lidar) {
                rays += Math.ceilDiv(lidar.rays(), sensor.every());
            }
        }
        return rays;
    }
}
