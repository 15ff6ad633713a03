// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldFile;
import reve.core.frame.Pacing;
import reve.worlds.server.Simulation;

import java.nio.charset.StandardCharsets;

/**
 * Bodies of substances slide and bounce as the closed forms say, in the worlds of {@code
 * docs/substances.md} and in others.
 */
class SubstancesIT {
    private static final double G = 9.81;
    private static final int RATE = 60;

    private static Simulation simulation(String world) throws Exception {
        return new Simulation(
                WorldFile.parse("w", world.getBytes(StandardCharsets.UTF_8)), Pacing.FAST);
    }

    /** Returns the world of the page with this name. */
    private static Simulation ofPage(String name) throws Exception {
        return ofPage("docs/substances.md", name);
    }

    private static Simulation ofPage(String page, String name) throws Exception {
        return simulation(
                Document.read(Project.ROOT.resolve(page)).blocks().stream()
                        .map(Document.Block::text)
                        .filter(text -> text.contains("name: " + name + "\n"))
                        .findFirst()
                        .orElseThrow());
    }

    private static double[] at(Simulation simulation, String item) {
        return simulation.world().find(item).orElseThrow().physical().location();
    }

    private static double speed(Simulation simulation, String item) {
        double[] v = simulation.world().find(item).orElseThrow().physics().vector("velocity");
        return Math.hypot(v[0], Math.hypot(v[1], v[2]));
    }

    /** On a slope of 10°, a body slides with g (sin 10° - μ cos 10°), or it stays. */
    @Test
    void bodiesSlideDownTheSlopeOfThePageAsTheirPairsSay() throws Exception {
        try (Simulation simulation = ofPage("slope")) {
            double sine = Math.sin(Math.toRadians(10));
            double cosine = Math.cos(Math.toRadians(10));
            simulation.loop().run(RATE);
            double skate = speed(simulation, "skate");
            double stone = speed(simulation, "curling stone");
            simulation.loop().run(RATE);
            assertThat(speed(simulation, "skate") - skate)
                    .as("the pair of steel and ice")
                    .isCloseTo(G * (sine - 0.02 * cosine), within(5e-3));
            assertThat(speed(simulation, "curling stone") - stone)
                    .as("the mean of granite and ice")
                    .isCloseTo(G * (sine - Math.sqrt(0.6 * 0.03) * cosine), within(5e-3));
            assertThat(speed(simulation, "tyre")).as("its own friction").isLessThan(1e-3);
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    @Test
    void aStoneOfThePageSlowsAsTheFrictionOfItsPairSays() throws Exception {
        try (Simulation simulation = ofPage("curling")) {
            simulation.loop().run(4 * RATE);
            assertThat(speed(simulation, "stone")).isCloseTo(2 - 0.015 * G * 4, within(5e-3));
        }
    }

    /** The decelerations are those below the world. */
    @Test
    void sledsOfThePageSlowOnImmovableItemsAsTheirPairsSay() throws Exception {
        try (Simulation simulation = ofPage("winter")) {
            simulation.loop().run(RATE / 2);
            assertThat(speed(simulation, "slow"))
                    .isCloseTo(4 - Math.sqrt(0.3 * 0.6) * G / 2, within(0.02 * 2.08));
            assertThat(speed(simulation, "fast"))
                    .isCloseTo(4 - Math.sqrt(0.3 * 0.03) * G / 2, within(0.02 * 0.47));
            assertThat(speed(simulation, "middle"))
                    .isCloseTo(4 - Math.sqrt(0.3 * 0.04) * G / 2, within(0.02 * 0.54));
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    /**
     * A block decelerates by μ g, and a ball that falls from the height h rises to e² h, on each
     * immovable shape. The values are those of the pair, which differ from those of the two
     * substances.
     */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "{shape: plane, size: [40, 8]}, physics: {substance: track}",
                "{shape: terrain, size: [40, 8], heights: [[0, 0, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0,"
                        + " 0, 0]]}, physics: {substance: track}",
                "{shape: mesh, vertices: [[-20, 0, -4], [20, 0, -4], [20, 0, 4], [-20, 0, 4]],"
                        + " triangles: [[0, 2, 1], [0, 3, 2]]}, physics: {substance: track, mass: 0}",
                "{shape: box, size: [40, 2, 8], location: [0, -1, 0]}, physics: {substance: track,"
                        + " mass: 0}"
            })
    void immovableShapesHaveTheFrictionAndRestitutionOfTheirPairs(String floor) throws Exception {
        String world =
                """
                reve: 1
                name: track
                frame: {rate: 60, steps: 16}
                laws: [gravity_field, {name: rigid_contact, parameters: {friction: 0.9}}]
                constants: {gravity: [0, -9.81, 0]}
                substances:
                  track: {friction: 0.8, restitution: 0.1, with: {steel: {friction: 0.25, restitution: 0.6}}}
                items:
                  - {name: floor, physical: FLOOR}
                  - {name: block, physical: {shape: box, size: [1, 0.2, 1], location: [-15, 0.1, 0.3]}, physics: {substance: steel, velocity: [6, 0, 0], restitution: 0}}
                  - {name: ball, physical: {shape: sphere, radius: 0.1, location: [11.3, 1.1, 1.2]}, physics: {substance: steel}}
                """
                        .replace("FLOOR", floor);
        try (Simulation simulation = simulation(world)) {
            simulation.loop().run(RATE / 2);
            double before = speed(simulation, "block");
            double top = 0;
            for (int frame = 0; frame < RATE; frame++) {
                simulation.loop().step();
                double v =
                        simulation
                                .world()
                                .find("ball")
                                .orElseThrow()
                                .physics()
                                .vector("velocity")[1];
                if (v > 0) {
                    top = Math.max(top, at(simulation, "ball")[1] - 0.1 + v * v / (2 * G));
                }
            }
            assertThat((before - speed(simulation, "block")) / G)
                    .as("friction")
                    .isCloseTo(0.25, within(0.02 * 0.25));
            assertThat(Math.sqrt(top)).as("restitution").isCloseTo(0.6, within(0.02 * 0.6));
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    /** A ball that falls from the height h rises to e² h. */
    @Test
    void ballsBounceToTheHeightsOfTheirSubstances() throws Exception {
        String world =
                """
                reve: 1
                name: bounce
                frame: {rate: 60, steps: 16}
                laws: [gravity_field, rigid_contact]
                constants: {gravity: [0, -9.81, 0]}
                substances:
                  clay: {density: 1700, friction: 1, restitution: 0}
                  steel: {with: {steel: {restitution: 0.6}, glass: {restitution: 0.7}}}
                prefabs:
                  ball: {physical: {shape: sphere, radius: 0.1}}
                items:
                  - {name: plate, physical: {shape: box, size: [20, 1, 9], location: [0, -0.5, 0]}, physics: {substance: steel, mass: 0}}
                  - {name: steel, like: ball, physical: {location: [-4, 1.1, 0]}, physics: {substance: steel}}
                  - {name: glass, like: ball, physical: {location: [-2, 1.1, 0]}, physics: {substance: glass}}
                  - {name: rubber, like: ball, physical: {location: [0, 1.1, 0]}, physics: {substance: rubber}}
                  - {name: clay, like: ball, physical: {location: [2, 1.1, 0]}, physics: {substance: clay}}
                  - {name: super, like: ball, physical: {location: [4, 1.1, 0]}, physics: {substance: glass, restitution: 0.9}}
                """;
        try (Simulation simulation = simulation(world)) {
            String[] balls = {"steel", "glass", "rubber", "clay", "super"};
            double[] restitution = {0.6, 0.7, 0.8, 0.56, 0.9};
            double[] top = new double[balls.length];
            boolean[] fell = new boolean[balls.length];
            boolean[] rose = new boolean[balls.length];
            for (int frame = 0; frame < 2 * RATE; frame++) {
                simulation.loop().step();
                for (int i = 0; i < balls.length; i++) {
                    double v =
                            simulation
                                    .world()
                                    .find(balls[i])
                                    .orElseThrow()
                                    .physics()
                                    .vector("velocity")[1];
                    fell[i] |= v < -1;
                    rose[i] |= fell[i] && v > 0;
                    if (rose[i] && (v > 0 || top[i] == 0)) {
                        // The height of the highest point follows from the present speed.
                        top[i] =
                                Math.max(
                                        top[i],
                                        at(simulation, balls[i])[1] - 0.1 + v * v / (2 * G));
                    }
                }
            }
            for (int i = 0; i < balls.length; i++) {
                assertThat(Math.sqrt(top[i])).as(balls[i]).isCloseTo(restitution[i], within(0.01));
            }
        }
    }

    /** The friction of a body without a substance is the parameter of the law, as before. */
    @Test
    void anOwnFrictionLeavesOtherBodiesAtTheParameterOfTheLaw() throws Exception {
        String world =
                """
                reve: 1
                name: sliding
                frame: {rate: 60, steps: 4}
                laws: [gravity_field, {name: rigid_contact, parameters: {friction: 0.4}}]
                constants: {gravity: [0, -9.81, 0]}
                items:
                  - {name: ground, physical: {shape: box, size: [99, 1, 9], location: [0, -0.5, 0]}}
                  - {name: plain, physical: {shape: box, size: [1, 0.2, 1], location: [0, 0.1, -2]}, physics: {mass: 1, velocity: [9, 0, 0]}}
                  - {name: rough, physical: {shape: box, size: [1, 0.2, 1], location: [0, 0.1, 0]}, physics: {mass: 1, velocity: [9, 0, 0], friction: 0.9}}
                  - {name: smooth, physical: {shape: box, size: [1, 0.2, 1], location: [0, 0.1, 2]}, physics: {mass: 1, velocity: [9, 0, 0], friction: 0}}
                """;
        try (Simulation simulation = simulation(world)) {
            simulation.loop().run(RATE);
            assertThat(speed(simulation, "plain")).isCloseTo(9 - 0.4 * G, within(0.02));
            assertThat(speed(simulation, "rough"))
                    .isCloseTo(9 - Math.sqrt(0.4 * 0.9) * G, within(0.02));
            assertThat(speed(simulation, "smooth")).isCloseTo(9, within(1e-3));
        }
    }

    /** The places and times are those of the text below the worlds. */
    @ParameterizedTest
    @CsvSource({
        "docs/substances.md, balls on felt, rolling, spinning, 1.07, 1.60, 40",
        "laws/rigid_contact/README.md, marbles, roller, spinner, 3.57, 2.04, 20"
    })
    void ballsOfThePagesRollAndSpinUntilTheyStopAndSleep(
            String page,
            String world,
            String rolling,
            String spinning,
            double way,
            double time,
            double spin)
            throws Exception {
        try (Simulation simulation = ofPage(page, world)) {
            double start = at(simulation, rolling)[0];
            int frames = (int) Math.round(time * RATE);
            simulation.loop().run(frames / 2);
            assertThat(spin(simulation, spinning)).isCloseTo(spin / 2, within(0.03 * spin));
            simulation.loop().run(frames - frames / 2 + 3);
            assertThat(spin(simulation, spinning)).isCloseTo(0, within(1e-3));
            simulation.loop().run(8 * RATE);
            assertThat(at(simulation, rolling)[0] - start).isCloseTo(way, within(0.02 * way));
            assertThat(speed(simulation, rolling)).isZero();
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    private static double spin(Simulation simulation, String item) {
        return simulation.world().find(item).orElseThrow().physics().vector("angularVelocity")[1];
    }
}
