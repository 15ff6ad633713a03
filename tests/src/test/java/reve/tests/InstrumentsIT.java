// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;

import reve.agent.AgentClient;
import reve.agent.Encoding;
import reve.agent.Join;
import reve.agent.LockStep;
import reve.agent.Perception;

import java.nio.DoubleBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;

/** The readings of a body's instruments, as agents receive them from a real server. */
class InstrumentsIT {
    @TempDir private Path folder;

    private Server serve(String world) throws Exception {
        Path file = Files.writeString(folder.resolve("world.yaml"), "reve: 1\nname: w\n" + world);
        return Server.start(
                folder,
                "serve",
                file.toString(),
                "--port",
                "0",
                "--json",
                "--deadline",
                "300",
                "--waiting",
                "off");
    }

    private static AgentClient join(Server server, Join join) throws Exception {
        return Agents.join(Integer.parseInt(server.port()), join);
    }

    private static Join inLockStep(Encoding encoding) {
        return Join.as("ada")
                .withEncoding(encoding)
                .withLockStep(LockStep.every(1).withDeadline(Duration.ofSeconds(300)));
    }

    private static double[] numbers(Perception perception, String sensor, String quantity) {
        DoubleBuffer buffer = perception.readings().get(sensor).numbers(quantity);
        double[] numbers = new double[buffer.remaining()];
        buffer.get(numbers);
        return numbers;
    }

    private static final String RIDER =
            """
            laws: [gravity_field, newton_motion, angular_motion]
            constants: {gravity: [0, -9.81, 0]}
            agents: {bodies: [rider]}
            items:
              - name: rider
                physical: {shape: sphere, radius: 0.5}
                physics: {mass: 2 kg, inertia: [1, 1, 1], angularVelocity: [0, 0, 0.5], appliedForce: [4, 19.62, 0]}
                sensors:
                  exact: {imu: {}}
                  slow: {imu: {}, every: 3}
                  rough: {imu: {specificForce: {noise: 0.1, bias: [0, 0, 5]}, angularVelocity: {noise: 1 deg/s}, seed: 11}}
              - {name: stone, physical: {shape: sphere, radius: 0.5, location: [0, 0, 3]}}
            """;

    /** The applied force carries the weight of the body and accelerates it by 2 m/s² along +X. */
    @Test
    void anAgentReadsItsImuAndPerceivesNothingElseWithIt() throws Exception {
        try (Server server = serve(RIDER);
                AgentClient ada = join(server, inLockStep(Encoding.JSON))) {
            Perception first = ada.observe();
            assertThat(first.items()).extracting(Perception.Item::name).containsExactly("rider");
            assertThat(first.readings()).containsOnlyKeys("exact", "slow", "rough");
            List<Long> slow = new ArrayList<>();
            for (int i = 0; i < 7; i++) {
                Perception now = ada.step();
                double turned = 0.5 * (now.time() - 1.0 / 120);
                assertThat(now.readings().get("exact").frame()).isEqualTo(now.frame());
                assertThat(numbers(now, "exact", "specificForce"))
                        .as("in the axes of the middle of the frame")
                        .containsExactly(
                                new double[] {
                                    2 * Math.cos(turned) + 9.81 * Math.sin(turned),
                                    9.81 * Math.cos(turned) - 2 * Math.sin(turned),
                                    0
                                },
                                within(1e-4));
                assertThat(numbers(now, "exact", "angularVelocity"))
                        .containsExactly(new double[] {0, 0, 0.5}, within(1e-9));
                slow.add(now.readings().get("slow").frame() - first.frame());
            }
            assertThat(slow).containsExactly(0L, 0L, 3L, 3L, 3L, 6L, 6L);
        }
    }

    private static List<double[]> rough(AgentClient agent) {
        List<double[]> readings = new ArrayList<>();
        for (int i = 0; i < 5; i++) {
            Perception now = agent.step();
            readings.add(numbers(now, "rough", "specificForce"));
            readings.add(numbers(now, "rough", "angularVelocity"));
        }
        return readings;
    }

    @Test
    void noiseHasTheSameBitsInEachRunInBothEncodingsAndAfterARewind() throws Exception {
        List<double[]> first;
        try (Server server = serve(RIDER);
                AgentClient ada = join(server, inLockStep(Encoding.JSON));
                AgentClient boss = join(server, Join.as("boss").withRole("control"))) {
            ada.observe();
            assertThat(boss.command("rewind", Map.of()).accepted()).isTrue();
            ada.observe();
            first = rough(ada);
            assertThat(boss.command("rewind", Map.of()).accepted()).isTrue();
            ada.observe();
            assertThat(rough(ada)).usingRecursiveComparison().isEqualTo(first);
        }
        assertThat(first.get(0)[2]).as("bias").isCloseTo(5, within(0.6));
        assertThat(first.get(0)).isNotEqualTo(first.get(2));
        try (Server server = serve(RIDER);
                AgentClient ada = join(server, inLockStep(Encoding.MESSAGEPACK));
                AgentClient boss = join(server, Join.as("boss").withRole("control"))) {
            ada.observe();
            assertThat(boss.command("rewind", Map.of()).accepted()).isTrue();
            ada.observe();
            assertThat(rough(ada)).usingRecursiveComparison().isEqualTo(first);
        }
    }

    private static Perception steps(AgentClient agent, int count) {
        for (int i = 1; i < count; i++) {
            agent.step();
        }
        return agent.step();
    }

    /** The box on the plate lies on its side. */
    @Test
    void agentsMeasureTheWeightAtTheirContacts() throws Exception {
        try (Server server =
                serve(
                        """
                                laws: [gravity_field, rigid_contact]
                                constants: {gravity: [0, -9.81, 0]}
                                agents: {bodies: [box, plate]}
                                items:
                                  - name: box
                                    physical: {shape: box, size: [1, 1, 1], location: [0, 1, 0], orientation: {axis: [0, 0, 1], angle: 90 deg}}
                                    physics: {mass: 3 kg}
                                    sensors: {world: {contactForce: {}}, own: {contactForce: {axes: body}}}
                                  - name: plate
                                    physical: {shape: box, size: [4, 1, 4]}
                                    physics: {mass: 0}
                                    sensors: {load: {contactForce: {}}}
                                """)) {
            double weight = 3 * 9.81;
            try (AgentClient ada = join(server, inLockStep(Encoding.JSON).withBody("box"))) {
                ada.observe();
                Perception now = steps(ada, 120);
                assertThat(numbers(now, "world", "force"))
                        .containsExactly(new double[] {0, weight, 0}, within(1e-3 * weight));
                assertThat(numbers(now, "own", "force"))
                        .as("the body's own +X axis points up")
                        .containsExactly(new double[] {weight, 0, 0}, within(1e-3 * weight));
            }
            try (AgentClient ada =
                    join(server, inLockStep(Encoding.MESSAGEPACK).withBody("plate"))) {
                ada.observe();
                assertThat(numbers(steps(ada, 3), "load", "force"))
                        .containsExactly(new double[] {0, -weight, 0}, within(1e-3 * weight));
            }
        }
    }

    @Test
    void theForcesOfSphereContactAreMeasuredToo() throws Exception {
        try (Server server =
                        serve(
                                """
                                frame: {rate: 60, steps: 20}
                                laws: [gravity_field, newton_motion, {name: sphere_contact, parameters: {floorHeight: 0, stiffness: 1e4, dampingRatio: 0.7}}]
                                constants: {gravity: [0, -9.81, 0]}
                                agents: {bodies: [ball]}
                                items:
                                  - name: ball
                                    physical: {shape: sphere, radius: 0.5, location: [0, 0.5, 0]}
                                    physics: {mass: 2 kg, radius: 0.5}
                                    sensors: {load: {contactForce: {}}}
                                """);
                AgentClient ada = join(server, inLockStep(Encoding.JSON))) {
            ada.observe();
            double weight = 2 * 9.81;
            assertThat(numbers(steps(ada, 120), "load", "force"))
                    .containsExactly(new double[] {0, weight, 0}, within(1e-3 * weight));
        }
    }

    /** Rays at -45, 0 and 45 degrees: past the wall, at the wall, and past the wall. */
    @Test
    void anAgentReadsTheDistancesOfItsLidarInBothEncodings() throws Exception {
        String world =
                """
                laws: [newton_motion]
                agents: {bodies: [cart]}
                items:
                  - name: cart
                    physical: {shape: box, size: [1, 1, 1]}
                    physics: {mass: 1 kg, velocity: [0, 0, 3]}
                    sensors: {scan: {lidar: {rays: 3, angle: 90 deg, range: 20 m}}}
                  - {name: wall, physical: {shape: box, size: [2, 2, 1], location: [0, 0, 9.5]}}
                """;
        for (Encoding encoding : Encoding.values()) {
            try (Server server = serve(world);
                    AgentClient ada = join(server, inLockStep(encoding))) {
                ada.observe();
                Perception now = steps(ada, 5);
                assertThat(now.items())
                        .extracting(Perception.Item::name)
                        .as("the wall is not disclosed")
                        .containsExactly("cart");
                assertThat(now.readings().get("scan").columns()).hasValue(3);
                assertThat(numbers(now, "scan", "distances"))
                        .containsExactly(
                                new double[] {
                                    Double.POSITIVE_INFINITY,
                                    9 - 3 * now.time(),
                                    Double.POSITIVE_INFINITY
                                },
                                within(1e-9));
            }
        }
    }
}
