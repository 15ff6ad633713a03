// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.core.world.Item;

import java.nio.charset.StandardCharsets;

/**
 * The motion of groups. Physics does not change under a translation and a rotation about the axis
 * of gravity, so a placed group moves as the same group at the origin.
 */
class GroupMotionNativeTest {
    private static final String WORLD =
            """
            reve: 1
            name: swings
            frame: {rate: 60, steps: 8}
            laws: [hooke_spring, gravity_field, rigid_contact]
            constants: {gravity: [0, -9.81, 0]}
            prefabs:
              swing:
                parts:
                  hook: {physical: {location: [0, 3, 0]}, physics: {mass: 0}}
                  bob:
                    physical: {shape: box, size: [0.2, 0.3, 0.4], location: [1, 3, 0.5]}
                    physics: {density: 500, velocity: [0, 0.5, 1], angularVelocity: [1, 2, 3]}
                  rope:
                    kind: spring
                    physics: {end1: hook, end2: bob, springConstant: 200, length: 1}
                  frame:
                    physical: {shape: box, size: [0.1, 2, 0.1], location: [3, 1, 0]}
                    physics: {mass: 0}
                  door:
                    physical: {shape: box, size: [0.9, 2, 0.04], location: [3.5, 1, 0]}
                    physics: {mass: 20, velocity: [0, 0, 1]}
                  hinge:
                    kind: joint
                    physics: {joined: [frame, door], jointType: hinge, axis: [0, 1, 0]}
            items:
              - {name: here, like: swing}
              - name: there
                like: swing
                physical: {location: [50, 7, -20], orientation: {axis: [0, 1, 0], angle: 70 deg}}
            """;

    @Test
    void aPlacedGroupMovesAsTheSameGroupAtTheOrigin() throws Exception {
        double angle = Math.toRadians(70);
        try (var simulation =
                new Simulation(
                        WorldFile.parse("w", WORLD.getBytes(StandardCharsets.UTF_8)),
                        Pacing.FAST)) {
            assertThat(simulation.warnings(true)).isEmpty();
            double[] start = at(simulation, "here.bob");
            simulation.loop().run(90);
            assertThat(simulation.events().faults()).isEmpty();
            for (String part : new String[] {"bob", "door"}) {
                double[] here = at(simulation, "here." + part);
                double[] there = at(simulation, "there." + part);
                assertThat(there[0])
                        .isCloseTo(
                                50 + Math.cos(angle) * here[0] + Math.sin(angle) * here[2],
                                within(1e-9));
                assertThat(there[1]).isCloseTo(7 + here[1], within(1e-9));
                assertThat(there[2])
                        .isCloseTo(
                                -20 - Math.sin(angle) * here[0] + Math.cos(angle) * here[2],
                                within(1e-9));
            }
            double[] end = at(simulation, "here.bob");
            assertThat(Math.hypot(end[0] - start[0], end[1] - start[1])).isGreaterThan(0.5);
            assertThat(at(simulation, "here.door")[0]).isLessThan(3.3);
        }
    }

    private static double[] at(Simulation simulation, String name) {
        Item item = simulation.world().find(name).orElseThrow();
        return item.physical().location();
    }
}
