package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import java.io.IOException;
import java.nio.file.Files;
import java.util.ArrayList;
import java.util.List;
import org.junit.jupiter.api.Test;
import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.world.Item;
import reve.worlds.server.Simulation;
import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

/** The paper's Figure 10, from the world file to the state after five seconds. */
class SpringOrbitIT {
    private static final JsonNode EXPECTED = expected();

    /** Two point masses and the spring between them, read from a world [SI units]. */
    private record Pair(double[] masses, double[][] positions, double[][] velocities) {
        static Pair of(Simulation simulation) {
            List<Item> bodies = new ArrayList<>();
            for (JsonNode name : EXPECTED.get("bodies")) {
                bodies.add(simulation.world().find(name.asString()).orElseThrow());
            }
            return new Pair(
                    bodies.stream().mapToDouble(body -> body.physics().scalar("mass")).toArray(),
                    bodies.stream().map(body -> body.physical().location()).toArray(double[][]::new),
                    bodies.stream().map(body -> body.physics().vector("velocity")).toArray(double[][]::new));
        }

        double[] momentum() {
            double[] sum = new double[3];
            for (int body = 0; body < 2; body++) {
                for (int axis = 0; axis < 3; axis++) {
                    sum[axis] += masses[body] * velocities[body][axis];
                }
            }
            return sum;
        }

        double[] line() {
            double[] line = new double[3];
            for (int axis = 0; axis < 3; axis++) {
                line[axis] = positions[1][axis] - positions[0][axis];
            }
            return line;
        }

        double distance() {
            return norm(line());
        }

        /** Kinetic energy in the centre-of-mass frame, plus that of the spring [J]. */
        double energy() {
            double reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
            double speedSquared = 0;
            for (int axis = 0; axis < 3; axis++) {
                double relative = velocities[1][axis] - velocities[0][axis];
                speedSquared += relative * relative;
            }
            double stretch = distance() - EXPECTED.get("restLength").asDouble();
            return 0.5 * reduced * speedSquared
                    + 0.5 * EXPECTED.get("springConstant").asDouble() * stretch * stretch;
        }
    }

    @Test
    void momentumEnergyDistanceAndAngleAreThoseOfTheClosedSystem() throws Exception {
        try (Simulation simulation = load()) {
            Pair before = Pair.of(simulation);
            double least = before.distance();
            double most = before.distance();
            for (long frame = 0; frame < frames(simulation); frame++) {
                simulation.loop().step();
                double distance = Pair.of(simulation).distance();
                least = Math.min(least, distance);
                most = Math.max(most, distance);
            }
            Pair after = Pair.of(simulation);

            double[] change = subtract(after.momentum(), before.momentum());
            assertThat(norm(change) / norm(before.momentum()))
                    .isLessThanOrEqualTo(EXPECTED.get("momentumRelativeChangeAtMost").asDouble());
            assertThat(Math.abs(after.energy() - before.energy()) / before.energy())
                    .isLessThanOrEqualTo(EXPECTED.get("energyRelativeChangeAtMost").asDouble());
            // At rest length the spring starts with the rounding of one square root.
            assertThat(least).isGreaterThanOrEqualTo(EXPECTED.at("/distance/from").asDouble() - 1e-12);
            assertThat(most).isLessThanOrEqualTo(EXPECTED.at("/distance/to").asDouble());
            assertThat(degreesBetween(before.line(), after.line()))
                    .isBetween(EXPECTED.at("/turnedDegrees/from").asDouble(),
                            EXPECTED.at("/turnedDegrees/to").asDouble());
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    @Test
    void twoRunsEndInTheSameState() throws Exception {
        assertThat(hashAfterRun()).isEqualTo(hashAfterRun());
    }

    private static long hashAfterRun() throws Exception {
        try (Simulation simulation = load()) {
            long before = simulation.physics().stateHash();
            simulation.loop().run(frames(simulation));
            long after = simulation.physics().stateHash();
            assertThat(after).isNotEqualTo(before);
            return after;
        }
    }

    private static Simulation load() throws IOException, WorldFileException {
        WorldDescription description = WorldFile.load(Project.WORLDS.resolve("spring-orbit/world.yaml"));
        return new Simulation(description, Pacing.FAST);
    }

    private static long frames(Simulation simulation) {
        return EXPECTED.get("seconds").asLong() * simulation.description().timing().framesPerSecond();
    }

    private static JsonNode expected() {
        try {
            return new JsonMapper().readTree(
                    Files.readString(Project.WORLDS.resolve("spring-orbit/expected.json")));
        } catch (IOException missing) {
            throw new AssertionError(missing);
        }
    }

    private static double[] subtract(double[] a, double[] b) {
        return new double[] {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    }

    private static double norm(double[] v) {
        return Math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }

    private static double degreesBetween(double[] a, double[] b) {
        double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        return Math.toDegrees(Math.acos(dot / (norm(a) * norm(b))));
    }
}
