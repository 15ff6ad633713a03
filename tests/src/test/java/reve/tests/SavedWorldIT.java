// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.RepeatedTest;
import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.io.TempDir;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.file.WorldFile;
import reve.core.file.WorldWriter;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Column;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ScalarType;
import reve.core.world.Table;
import reve.core.world.World;
import reve.tests.Reve.Outcome;
import reve.worlds.journal.SimulationImage;
import reve.worlds.server.Simulation;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.TreeMap;
import java.util.stream.Stream;

/** A world that was saved to a world file continues unchanged. */
@Tag("slow")
class SavedWorldIT {
    private static final int FRAMES = 30;

    @TempDir private Path folder = Path.of("");

    private static Simulation load(Path world) throws Exception {
        return new Simulation(WorldFile.load(world), Pacing.FAST);
    }

    private static Path sample(String name) {
        return Project.WORLDS.resolve(name).resolve("world.yaml");
    }

    @ParameterizedTest
    @ValueSource(strings = {"spring-orbit", "spiderweb"})
    void goesOnToTheBit(String sample) throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = load(sample(sample))) {
            first.loop().run(FRAMES);
            WorldFile.save(saved, first.descriptionNow());
            try (Simulation second = load(saved)) {
                for (int frame = 1; frame <= FRAMES; frame++) {
                    first.loop().step();
                    second.loop().step();
                    assertThat(state(second))
                            .as("%d frames after saving", frame)
                            .isEqualTo(state(first));
                }
            }
        }
    }

    @ParameterizedTest
    @ValueSource(strings = {"spring-orbit", "spiderweb", "icosahedron"})
    void isTheSameWorldWhenItIsReadAgain(String sample) throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = load(sample(sample))) {
            first.loop().run(FRAMES);
            WorldFile.save(saved, first.descriptionNow());
            try (Simulation second = load(saved)) {
                second.loop().run(0); // computes the values that are not in the file
                assertThat(state(second)).isEqualTo(state(first));
                assertThat(WorldWriter.write(second.descriptionNow()))
                        .isEqualTo(Files.readString(saved));
            }
        }
    }

    /** The hash includes the number of steps, too. */
    @Test
    void goesOnAtItsTime() throws Exception {
        Path saved = folder.resolve("saved.yaml");
        try (Simulation first = load(sample("spring-orbit"))) {
            first.loop().run(FRAMES);
            WorldFile.save(saved, first.descriptionNow());
            assertThat(Files.readString(saved)).contains("age: " + FRAMES);
            List<Double> times = new ArrayList<>();
            try (Simulation second = load(saved)) {
                second.onPublish("times", frame -> times.add(frame.timeSeconds()));
                second.loop().step();
                first.loop().step();
                Timing timing = second.description().timing();
                assertThat(times)
                        .containsExactly(
                                timing.timeSeconds(FRAMES), timing.timeSeconds(FRAMES + 1));
                assertThat(second.physics().stateHash()).isEqualTo(first.physics().stateHash());
            }
        }
    }

    @Test
    void whatItCannotHoldIsSaid() throws Exception {
        try (Simulation world = load(sample("spring-orbit"))) {
            assertThat(world.notDescribed()).isEmpty();
            world.physics().laws().load(0, "surface_contact", Map.of());
            assertThat(world.notDescribed())
                    .containsExactly(
                            "what surface_contact remembers of earlier steps (frictionStretch,"
                                    + " frictionUse)");
        }
    }

    private static int repetitions;
    private static int forces;

    /**
     * A random world has random changes while it runs. The saved world of any frame continues with
     * the same bits, with the results of rules, and with forces that actions began.
     */
    @RepeatedTest(5)
    void aRandomWorldGoesOnToTheBitFromAnyFrame() throws Exception {
        long seed = Long.getLong("reve.test.seed", System.nanoTime());
        System.out.println("SavedWorldIT seed " + seed);
        Random random = new Random(seed);
        Path begun = Files.writeString(folder.resolve("world.yaml"), randomWorld(random));
        Path saved = folder.resolve("saved.yaml");
        repetitions++;
        try (Simulation first = load(begun)) {
            for (int frame = 0; frame < 40; frame++) {
                happen(first.world(), random);
                first.loop().step();
                if (random.nextInt(8) > 0) {
                    continue;
                }
                forces += first.world().forces().active().size();
                WorldFile.save(saved, first.descriptionNow());
                try (Simulation second = load(saved);
                        SimulationImage image = first.keep();
                        Simulation undisturbed = first.fork(image)) {
                    undisturbed.world().guard().claim();
                    for (int i = 1; i <= FRAMES; i++) {
                        undisturbed.loop().step();
                        second.loop().step();
                        String what =
                                "seed "
                                        + seed
                                        + ", saved after frame "
                                        + frame
                                        + ", "
                                        + i
                                        + " later";
                        assertThat(second.physics().stateHash())
                                .as(what)
                                .isEqualTo(undisturbed.physics().stateHash());
                        assertThat(state(second)).as(what).isEqualTo(state(undisturbed));
                        assertThat(symbols(second.world()))
                                .as(what)
                                .isEqualTo(symbols(undisturbed.world()));
                    }
                }
            }
        }
    }

    /**
     * One random world may have no such forces. If five worlds have none, the worlds are not
     * random.
     */
    @AfterAll
    static void forcesStillActedInSomeSavedWorld() {
        assertThat(repetitions == 0 ? 1 : forces).as("forces that still acted").isPositive();
    }

    private static String randomWorld(Random random) {
        StringBuilder text =
                new StringBuilder(
                        """
                        reve: 1
                        name: random
                        prototype: %s
                        frame: {rate: 60, steps: %d}
                        laws: [newton_motion, hooke_spring, {name: gravity_field}, drag]
                        constants: {gravity: [0, -1, 0]}
                        rules: {fast: "norm(physics.velocity) > 1.0"}
                        items:
                        """
                                .formatted(
                                        random.nextBoolean() ? "si-f32" : "si-f64",
                                        1 + random.nextInt(3)));
        for (int i = 0; i < 12; i++) {
            text.append(
                    """
                      - name: b%d
                        physical: {shape: sphere, radius: 0.1, location: [%s, %s, %s]}
                        physics: {mass: %s, dragCoefficient: 0.1}
                        access: {push: {effects: [{force: [%s, 1, 0], for: %s}]}}
                    """
                            .formatted(
                                    i,
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    random.nextInt(5) == 0 ? 0 : random.nextDouble(),
                                    random.nextGaussian(),
                                    random.nextDouble()));
            if (i > 0) {
                text.append(
                        ("  - {name: s%d, kind: spring, physics: {end1: b%d, end2: b%d, "
                                        + "length: 1, springConstant: %s, dampingConstant: 0.1}}\n")
                                .formatted(i, i, random.nextInt(i), random.nextDouble()));
            }
        }
        return text.toString();
    }

    /** Performs one act of an actor or an operator between two frames. */
    private static void happen(World world, Random random) throws ActionRefused {
        List<Item> bodies =
                world.items().stream().filter(item -> item.kind().equals("body")).toList();
        Item item = bodies.get(random.nextInt(bodies.size()));
        Item other = bodies.get(random.nextInt(bodies.size()));
        switch (random.nextInt(8)) {
            case 0, 1, 2 -> push(world, item);
            case 3 ->
                    item.physics().set("velocity", random.nextGaussian(), random.nextGaussian(), 0);
            case 4 ->
                    world.add(
                            ItemDefinition.named("new " + world.lastId())
                                    .at(random.nextGaussian(), 0, 0)
                                    .physics("mass", 0)
                                    .build());
            case 5 -> {
                if (bodies.size() > 6) {
                    world.removeCascade(item.id());
                }
            }
            case 6 -> world.rename(item.id(), "renamed " + random.nextInt(1 << 20));
            default -> {
                item.physics().set("mass", 0);
                if (item.parent().isPresent()) {
                    world.detach(item.id());
                } else if (!moves(world, other, item)) {
                    world.attach(item.id(), other.id());
                }
            }
        }
    }

    private static void push(World world, Item item) throws ActionRefused {
        Optional<Action> push = item.access().find("push");
        if (push.isPresent() && item.physics().scalar("mass") > 0) {
            new ActionCall(world, 0, item, Optional.empty(), Arguments.check(push.get(), Map.of()))
                    .perform(push.get());
        }
    }

    /** Returns whether an item is the other one or moves with it. */
    private static boolean moves(World world, Item item, Item with) {
        return item == with
                || item.parent()
                        .filter(parent -> moves(world, world.item(parent), with))
                        .isPresent();
    }

    private static Map<String, Object> symbols(World world) {
        Map<String, Object> symbols = new TreeMap<>();
        world.items().forEach(item -> symbols.put(item.name(), item.semantic().symbols()));
        return symbols;
    }

    /** Returns the bits of every number in rows that laws use, and the targets of references. */
    private static List<Object> state(Simulation simulation) {
        World world = simulation.world();
        List<Object> state = new ArrayList<>();
        for (Table table : world.tables()) {
            for (int row = 0; row < table.physicsRowCount(); row++) {
                Item item = world.item(table.idAt(row));
                state.add(item.name());
                for (Column column : table.columns()) {
                    for (int i = 0;
                            i < column.components() && column.type() != ScalarType.REF;
                            i++) {
                        state.add(Double.doubleToRawLongBits(column.getDouble(row, i)));
                    }
                }
                state.add(item.definition().references());
            }
        }
        return state;
    }

    @Test
    void runSavesWhatItEndsWith() throws Exception {
        Path saved = folder.resolve("orbit.yaml");
        String orbit = Project.WORLDS.resolve("spring-orbit").toString();

        Outcome run = Reve.run("run", orbit, "--seconds", "0.5", "--save", saved.toString());

        assertThat(run.code()).as(run.err()).isZero();
        assertThat(Reve.run("check", saved.toString()).out()).startsWith(saved + ": valid");
        assertThat(listing()).containsExactly("orbit.yaml");
        Outcome nowhere =
                Reve.run(
                        "run",
                        orbit,
                        "--seconds",
                        "0",
                        "--save",
                        folder.resolve("none/x.yaml").toString());
        assertThat(nowhere.code()).isEqualTo(2);
        assertThat(nowhere.err()).contains("--save").contains("there is no folder");
    }

    private List<String> listing() throws IOException {
        try (Stream<Path> files = Files.list(folder)) {
            return files.map(file -> file.getFileName().toString()).toList();
        }
    }
}
