// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.MethodSource;

import reve.core.file.WorldDescription;
import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.core.frame.Pacing;
import reve.core.world.WorldEvent;
import reve.worlds.server.Simulation;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.stream.Stream;

/**
 * Checks the promises of every sample world with a {@code world.yaml}, and of each of its {@code
 * variants}. The file {@code expected.json} has the promises. If a scene promises something else,
 * those of the world are under {@code world} in it. The test loads the world file and checks the
 * state after some seconds. In every world, immovable items stay at their places and no law fails.
 */
@Tag("slow")
class WorldsIT {
    private static final long MOST_FRAMES_TWICE = 60;

    /** A world file, and the conditions that it must meet. */
    record Sample(Path file, JsonNode expected) {
        Simulation load() throws IOException, WorldFileException {
            WorldDescription description = WorldFile.load(file);
            return new Simulation(description, Pacing.FAST);
        }

        long frames(Simulation simulation) {
            return expected.has("frames")
                    ? expected.get("frames").asLong()
                    : expected.get("seconds").asLong()
                            * simulation.description().timing().framesPerSecond();
        }

        List<JsonNode> all(String key) {
            List<JsonNode> nodes = new ArrayList<>();
            expected.path(key).forEach(nodes::add);
            return nodes;
        }

        @Override
        public String toString() {
            return file.getParent().getFileName() + "/" + file.getFileName();
        }
    }

    static List<Sample> samples() throws IOException {
        List<Sample> samples = new ArrayList<>();
        try (Stream<Path> folders = Files.list(Project.WORLDS)) {
            for (Path folder : folders.sorted().toList()) {
                if (Files.exists(folder.resolve("world.yaml"))) {
                    String expected = Files.readString(folder.resolve("expected.json"));
                    JsonNode tree = new JsonMapper().readTree(expected);
                    JsonNode own = tree.has("world") ? tree.get("world") : tree;
                    samples.add(new Sample(folder.resolve("world.yaml"), own));
                    tree.path("variants")
                            .forEach(
                                    variant ->
                                            samples.add(
                                                    new Sample(
                                                            folder.resolve(variant.asString()),
                                                            own)));
                }
            }
        }
        return samples;
    }

    @ParameterizedTest
    @MethodSource("samples")
    void whatIsExpectedOfTheWorldHolds(Sample sample) throws Exception {
        try (Simulation simulation = sample.load()) {
            var mechanics = new Mechanics(simulation);
            List<WorldEvent> events = new ArrayList<>();
            simulation.onPublish("events", frame -> events.addAll(frame.world().events()));
            var before = mechanics.state();
            for (long frame = 0; frame < sample.frames(simulation); frame++) {
                simulation.loop().step();
                checkFrame(sample, before, mechanics.state());
            }
            checkEnd(sample, before, mechanics.state());
            checkSizes(sample, simulation);
            checkLevels(sample, events);
            for (Map.Entry<String, JsonNode> mean : sample.expected().path("meanX").properties()) {
                assertWithin(
                        mean.getValue(),
                        mechanics.meanX(mean.getKey()),
                        "mean x of " + mean.getKey());
            }
            assertThat(simulation.events().faults()).isEmpty();
        }
    }

    static List<Sample> variants() throws IOException {
        return samples().stream()
                .filter(
                        sample ->
                                sample.expected().has("variants")
                                        && !sample.file().endsWith("world.yaml"))
                .toList();
    }

    @ParameterizedTest
    @MethodSource("variants")
    void aVariantEndsWhereTheWorldDoes(Sample variant) throws Exception {
        Sample world = new Sample(variant.file().resolveSibling("world.yaml"), variant.expected());
        var expected = endOf(world).positions();
        var found = endOf(variant);
        assertThat(found.positions().keySet()).isEqualTo(expected.keySet());
        double most = variant.expected().get("variantsApartAtMost").asDouble();
        assertThat(expected.keySet())
                .allSatisfy(
                        item -> {
                            double[] apart =
                                    Mechanics.subtract(found.position(item), expected.get(item));
                            assertThat(Mechanics.norm(apart)).isLessThanOrEqualTo(most);
                        });
    }

    private static Mechanics.State endOf(Sample sample) throws Exception {
        try (Simulation simulation = sample.load()) {
            simulation.loop().run(sample.frames(simulation));
            return new Mechanics(simulation).state();
        }
    }

    @ParameterizedTest
    @MethodSource("samples")
    void twoRunsEndInTheSameState(Sample sample) throws Exception {
        assertThat(hashAfterRun(sample)).isEqualTo(hashAfterRun(sample));
    }

    private static void checkFrame(Sample sample, Mechanics.State before, Mechanics.State now) {
        assertThat(now.immovable()).isEqualTo(before.immovable());
        if (sample.expected().path("energyNeverAboveStart").asBoolean(false)) {
            assertThat(now.energy()).isLessThanOrEqualTo(before.energy());
        }
        for (JsonNode expected : sample.all("distances")) {
            // At rest length, a spring starts with the rounding of one square root.
            assertThat(Mechanics.norm(line(expected, now)))
                    .isBetween(
                            expected.get("from").asDouble() - 1e-12, expected.get("to").asDouble());
        }
    }

    private static void checkEnd(Sample sample, Mechanics.State before, Mechanics.State after) {
        JsonNode expected = sample.expected();
        if (expected.has("momentumRelativeChangeAtMost")) {
            double change = Mechanics.norm(Mechanics.subtract(after.momentum(), before.momentum()));
            assertThat(change / Mechanics.norm(before.momentum()))
                    .isLessThanOrEqualTo(expected.get("momentumRelativeChangeAtMost").asDouble());
        }
        if (expected.has("momentumChangeAtMost")) {
            assertThat(Mechanics.norm(Mechanics.subtract(after.momentum(), before.momentum())))
                    .isLessThanOrEqualTo(expected.get("momentumChangeAtMost").asDouble());
        }
        if (expected.has("farthestMoveAtLeast")) {
            assertThat(
                            after.positions().keySet().stream()
                                    .mapToDouble(
                                            item ->
                                                    Mechanics.norm(
                                                            Mechanics.subtract(
                                                                    after.position(item),
                                                                    before.position(item))))
                                    .max()
                                    .orElseThrow())
                    .isGreaterThanOrEqualTo(expected.get("farthestMoveAtLeast").asDouble());
        }
        if (expected.has("kineticEnergyLeft")) {
            assertWithin(
                    expected.get("kineticEnergyLeft"),
                    after.kineticEnergy() / before.kineticEnergy(),
                    "kinetic energy left");
        }
        if (expected.has("energyRelativeChangeAtMost")) {
            assertThat(Math.abs((after.energy() - before.energy()) / before.energy()))
                    .isLessThanOrEqualTo(expected.get("energyRelativeChangeAtMost").asDouble());
        }
        for (JsonNode turned : sample.all("turnedDegrees")) {
            assertThat(Mechanics.degreesBetween(line(turned, before), line(turned, after)))
                    .isBetween(turned.get("from").asDouble(), turned.get("to").asDouble());
        }
        for (JsonNode position : sample.all("positions")) {
            double[] at = after.position(position.get("item").asString());
            double[] expectedPlace = new double[3];
            for (int axis = 0; axis < 3; axis++) {
                expectedPlace[axis] = position.get("at").get(axis).asDouble();
            }
            assertThat(Mechanics.norm(Mechanics.subtract(at, expectedPlace)))
                    .as("%s is at %s", position.get("item"), List.of(at[0], at[1], at[2]))
                    .isLessThanOrEqualTo(position.get("within").asDouble());
        }
    }

    private static void checkSizes(Sample sample, Simulation simulation) {
        for (JsonNode expected : sample.all("sizes")) {
            String name = expected.get("item").asString();
            double[] size = simulation.world().find(name).orElseThrow().physical().size();
            for (int axis = 0; axis < 3; axis++) {
                assertThat(size[axis])
                        .as("size %d of %s", axis, name)
                        .isCloseTo(
                                expected.get("is").get(axis).asDouble(),
                                within(expected.get("within").asDouble()));
            }
        }
    }

    /** Checks the levels that items took one after another. */
    private static void checkLevels(Sample sample, List<WorldEvent> events) {
        List<WorldEvent> changes =
                events.stream().filter(event -> event.type().equals("level-changed")).toList();
        assertThat(changes.isEmpty()).isEqualTo(sample.all("levels").isEmpty());
        for (JsonNode expected : sample.all("levels")) {
            List<String> levels = new ArrayList<>();
            expected.get("become").forEach(level -> levels.add(level.asString()));
            List<WorldEvent> own =
                    changes.stream()
                            .filter(
                                    event ->
                                            event.fields()
                                                    .get("item")
                                                    .equals(expected.get("item").asString()))
                            .toList();
            assertThat(own).extracting(event -> event.fields().get("to")).isEqualTo(levels);
        }
    }

    private static void assertWithin(JsonNode range, double value, String what) {
        assertThat(value)
                .as(what)
                .isBetween(range.get("from").asDouble(), range.get("to").asDouble());
    }

    /** Returns the vector from the first to the second of two items. */
    private static double[] line(JsonNode expected, Mechanics.State state) {
        JsonNode between = expected.get("between");
        return Mechanics.subtract(
                state.position(between.get(1).asString()),
                state.position(between.get(0).asString()));
    }

    private static long hashAfterRun(Sample sample) throws Exception {
        try (Simulation simulation = sample.load()) {
            long before = simulation.physics().stateHash();
            simulation.loop().run(Math.min(MOST_FRAMES_TWICE, sample.frames(simulation)));
            long after = simulation.physics().stateHash();
            assertThat(after).isNotEqualTo(before);
            return after;
        }
    }
}
