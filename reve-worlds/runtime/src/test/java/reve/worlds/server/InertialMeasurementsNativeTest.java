// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.assertj.core.data.Offset;
import org.junit.jupiter.api.Test;

import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.worlds.journal.SimulationImage;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;

/** Specific force and angular velocity of bodies, compared with closed forms. */
class InertialMeasurementsNativeTest {
    private static final double GRAVITY = 9.81;
    private static final double FRAME = 1.0 / 60;

    private static Simulation run(int frames, String rest) throws WorldFileException {
        String text = "reve: 1\nname: w\n" + rest;
        var simulation =
                new Simulation(
                        WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)), Pacing.FAST);
        simulation.loop().run(frames);
        assertThat(simulation.events().faults()).isEmpty();
        return simulation;
    }

    private static double[] force(Simulation simulation, String item) {
        return numbers(simulation, item, "specificForce");
    }

    private static double[] rate(Simulation simulation, String item) {
        return numbers(simulation, item, "angularRate");
    }

    private static double[] numbers(Simulation simulation, String item, String property) {
        var bodies = simulation.world().table("body");
        int row = bodies.rowOf(simulation.world().find(item).orElseThrow().id());
        double[] numbers = new double[3];
        Arrays.setAll(numbers, i -> bodies.column(property).getDouble(row, i));
        return numbers;
    }

    private static double length(double[] vector) {
        return Math.sqrt(Arrays.stream(vector).map(x -> x * x).sum());
    }

    /** Mean of a vector that rotates by this angle, divided by its length. */
    private static double mean(double angle) {
        return Math.sin(angle / 2) / (angle / 2);
    }

    /** 720,000 pairs of sensors and bodies, of which the world computes 500,000. */
    @Test
    void tooManySensorsUnderGravitationAreReportedAndMeasureNothing() throws WorldFileException {
        String text =
                """
                reve: 1
                name: w
                laws: [newton_gravitation, drag, newton_motion]
                constants: {gravitationalConstant: 1, softening: 1}
                items:
                  - {name: 'a{i}', repeat: 600, physical: {location: ['{3 * i}', 0, 0]},
                     physics: {mass: 1, velocity: [0, 0, 10], linearDragCoefficient: 0.5},
                     sensors: {imu: {imu: {}}}}
                  - {name: 'b{i}', repeat: 600, physical: {location: ['{3 * i}', 9, 0]},
                     physics: {mass: 1}}
                """;
        try (var simulation =
                new Simulation(
                        WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8)), Pacing.FAST)) {
            simulation.loop().run(3);
            assertThat(simulation.events().faults())
                    .singleElement()
                    .satisfies(
                            fault ->
                                    assertThat(fault.fields().get("message").toString())
                                            .contains("600 items have an `imu`", "of 416 items"));
            double drag = -0.5 * 10 * Math.exp(-0.5 * 2.5 * FRAME);
            assertThat(force(simulation, "a0")[2]).isCloseTo(drag, within(0.05));
            assertThat(force(simulation, "a415")[2]).isCloseTo(drag, within(0.05));
            assertThat(length(force(simulation, "a416"))).isZero();
        }
    }

    @Test
    void aBodyInFreeFallFeelsNothing() throws WorldFileException {
        try (Simulation simulation =
                run(
                        90,
                        """
                        laws: [gravity_field, newton_motion, angular_motion]
                        constants: {gravity: [0, -9.81, 0]}
                        items:
                          - name: a
                            physics: {mass: 2, inertia: [1, 1, 1], velocity: [3, 9, 0], angularVelocity: [1, 2, 3]}
                            sensors: {imu: {imu: {}}}
                        """)) {
            assertThat(force(simulation, "a")).containsExactly(new double[3], within(1e-9));
        }
    }

    /** Turned by a quarter about +X, the body's own -Z axis points up. */
    @Test
    void aBodyAtRestOnAFloorFeelsTheFloorHoldIt() throws WorldFileException {
        try (Simulation simulation =
                run(
                        180,
                        """
                        laws: [gravity_field, rigid_contact]
                        constants: {gravity: [0, -9.81, 0]}
                        items:
                          - {name: floor, physical: {shape: box, size: [9, 1, 9], location: [0, -0.5, 0]}}
                          - name: a
                            physical: {shape: box, size: [1, 1, 1], location: [0, 0.5, 0], orientation: {axis: [1, 0, 0], angle: 90 deg}}
                            physics: {mass: 3}
                            sensors: {imu: {imu: {}}}
                          - name: post
                            physical: {shape: box, size: [1, 1, 1], location: [3, 0.5, 0], orientation: {axis: [0, 0, 1], angle: 90 deg}}
                            sensors: {imu: {imu: {}}}
                        """)) {
            Offset<Double> law = within(1e-3 * GRAVITY);
            assertThat(force(simulation, "a")).containsExactly(new double[] {0, 0, -GRAVITY}, law);
            assertThat(rate(simulation, "a")).containsExactly(new double[3], within(1e-3));
            assertThat(force(simulation, "post"))
                    .as("scenery, turned by a quarter about +Z")
                    .containsExactly(new double[] {GRAVITY, 0, 0}, within(1e-12));
        }
    }

    /** A charge in a magnetic field: v²/r = v q B / m, towards the centre. */
    @Test
    void aBodyInACircleFeelsTheCentripetalAcceleration() throws WorldFileException {
        double speed = 2;
        double turning = 1.5;
        try (Simulation simulation =
                run(
                        40,
                        """
                        frame: {rate: 60, steps: 100}
                        laws: [lorentz_field, newton_motion]
                        constants: {magneticField: 0 1.5 0 T}
                        items:
                          - name: a
                            physics: {mass: 1, charge: 1 C, velocity: [2, 0, 0]}
                            sensors: {imu: {imu: {}}}
                        """)) {
            double[] felt = force(simulation, "a");
            double radius = speed / turning;
            assertThat(length(felt))
                    .isCloseTo(
                            speed * speed / radius * mean(turning * FRAME),
                            within(1e-3 * speed * turning));
            double[] velocity = numbers(simulation, "a", "velocity");
            double half = turning * FRAME / 2;
            double along =
                    (felt[0] * velocity[0] + felt[2] * velocity[2])
                            / (length(felt) * length(velocity));
            assertThat(along)
                    .as("perpendicular to the velocity in the middle of the frame")
                    .isCloseTo(Math.sin(half), within(1e-3));
        }
    }

    /** An arm on a hub that spins about +Y feels ω² r towards the hub, in its own axes. */
    @Test
    void anAttachedBodyMovesRigidlyWithItsCarrier() throws WorldFileException {
        double turning = 4;
        double radius = 1.5;
        try (Simulation simulation =
                run(
                        25,
                        """
                        laws: [gravity_field, newton_motion, angular_motion]
                        constants: {gravity: [0, -9.81, 0]}
                        items:
                          - name: hub
                            physics: {mass: 5, inertia: [1, 1, 1], angularVelocity: [0, 4, 0], velocity: [1, 0, 0]}
                            sensors: {imu: {imu: {}}}
                          - name: rod
                            parent: hub
                            physical: {location: [1, 0, 0]}
                          - name: tip
                            parent: rod
                            physical: {location: [0.5, 0, 0], orientation: {axis: [0, 1, 0], angle: 180 deg}}
                            sensors: {imu: {imu: {}}}
                        """)) {
            double expected = turning * turning * radius * mean(turning * FRAME);
            Offset<Double> close = within(1e-5 * expected);
            assertThat(force(simulation, "hub")).containsExactly(new double[3], within(1e-9));
            assertThat(force(simulation, "tip"))
                    .as("the tip's +X axis points to the hub")
                    .containsExactly(new double[] {expected, 0, 0}, close);
            assertThat(rate(simulation, "tip"))
                    .containsExactly(new double[] {0, turning, 0}, within(1e-9));
        }
    }

    @Test
    void theAngularVelocityIsInTheBodysOwnAxes() throws WorldFileException {
        try (Simulation simulation =
                run(
                        1,
                        """
                        laws: [newton_motion, angular_motion]
                        items:
                          - name: a
                            physical: {orientation: {axis: [1, 0, 0], angle: 90 deg}}
                            physics: {mass: 1, inertia: [1, 1, 1], angularVelocity: [0, 0, 3]}
                            sensors: {imu: {imu: {}}}
                        """)) {
            assertThat(rate(simulation, "a")).containsExactly(new double[] {0, 3, 0}, within(1e-9));
        }
    }

    /** The field changes during a frame, so a small part of it remains. */
    @Test
    void aSatelliteFeelsAlmostNothingOfThePlanetsGravitation() throws WorldFileException {
        String world =
                """
                frame: {rate: 60, steps: 16}
                laws: [newton_gravitation, newton_motion]
                constants: {gravitationalConstant: 1}
                items:
                  - {name: planet, physics: {mass: 1e6}}
                  - name: moon
                    physical: {location: [100, 0, 0]}
                    physics: {mass: 1, velocity: [0, 0, 100]}
                    sensors: {imu: {imu: {}}}
                """;
        try (Simulation simulation = run(60, world)) {
            double weight = 1e6 / (100 * 100);
            assertThat(length(force(simulation, "moon"))).isLessThan(1e-3 * weight);
        }
    }

    @Test
    void anEditOfTheVelocityIsNoAcceleration() throws WorldFileException {
        try (Simulation simulation =
                run(
                        3,
                        """
                        laws: [newton_motion]
                        items: [{name: a, physics: {mass: 1}, sensors: {imu: {imu: {}}}}]
                        """)) {
            simulation.world().find("a").orElseThrow().physics().set("velocity", 0, 50, 0);
            simulation.loop().step();
            assertThat(force(simulation, "a")).containsExactly(0, 0, 0);
            simulation.world().find("a").orElseThrow().physics().set("appliedForce", 0, 5, 0);
            simulation.loop().step();
            assertThat(force(simulation, "a"))
                    .containsExactly(new double[] {0, 5, 0}, within(1e-9));
        }
    }

    @Test
    void afterARewindTheSameIsMeasuredAgain() throws WorldFileException {
        try (Simulation simulation =
                run(
                        10,
                        """
                        frame: {rate: 60, steps: 2}
                        laws: [gravity_field, rigid_contact]
                        constants: {gravity: [0, -9.81, 0]}
                        items:
                          - {name: floor, physical: {shape: box, size: [9, 1, 9], location: [0, -0.5, 0]}}
                          - name: a
                            physical: {shape: box, size: [1, 1, 1], location: [0, 0.7, 0], orientation: {axis: [1, 0, 1], angle: 20 deg}}
                            physics: {mass: 3}
                            sensors: {imu: {imu: {}}}
                        """)) {
            try (SimulationImage image = simulation.keep()) {
                double[] before = force(simulation, "a");
                List<double[]> first = measured(simulation);
                simulation.rewind(image);
                simulation.loop().run(0);
                assertThat(force(simulation, "a")).containsExactly(before);
                List<double[]> second = measured(simulation);
                assertThat(second).usingRecursiveComparison().isEqualTo(first);
            }
        }
    }

    private static List<double[]> measured(Simulation simulation) {
        List<double[]> all = new ArrayList<>();
        for (int i = 0; i < 30; i++) {
            simulation.loop().step();
            all.add(force(simulation, "a"));
            all.add(rate(simulation, "a"));
        }
        return all;
    }
}
