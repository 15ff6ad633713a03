// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.rule.Rule;
import reve.core.world.Column;
import reve.core.world.Forces;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.OffHeapArena;
import reve.core.world.ScalarType;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Random;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/**
 * Worlds that are written and read are equal. The seed is printed; -Dreve.test.seed=N repeats it,
 * and -Dreve.test.worlds=N sets their number.
 */
class WorldWriterTest {
    private static final int WORLDS = Integer.getInteger("reve.test.worlds", 200);

    private final long seed = Seed.of("worlds");
    private final Random random = new Random(seed);

    private static List<Rule> rules(int from, int to) throws WorldFileException {
        String rules =
                IntStream.range(from, to)
                        .mapToObj(i -> "r" + i + ": 'physics.mass > " + i + ".0'")
                        .collect(Collectors.joining(", "));
        return WorldFileTest.parse("reve: 1\nname: w\nrules: {" + rules + "}\n").rules();
    }

    /** Otherwise a saved world could not be read again. */
    @Test
    void whatExceedsALimitOfWorldFilesIsRefused() throws WorldFileException {
        WorldDescription world = WorldFileTest.parse("reve: 1\nname: w\n");
        List<Rule> most = rules(0, 256);
        WorldFileTest.parse(WorldWriter.write(world.withRules(most)));
        List<Rule> more = new ArrayList<>(most);
        more.addAll(rules(256, 257));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> WorldWriter.write(world.withRules(more)))
                .withMessage("world w has 257 rules, of which a world file holds 256");
    }

    /** Edits of a running world may add conditions again and again. */
    @Test
    void aWorldWithMoreConditionsThanAWorldFileHoldsIsNotSaved() throws WorldFileException {
        WorldDescription most = WorldFileTest.parse(withConditions("a", 0, 5000));
        WorldWriter.write(most);
        List<ItemDefinition> items = new ArrayList<>(most.items());
        items.addAll(WorldFileTest.parse(withConditions("b", 4900, 5000)).items());
        WorldWriter.write(withItems(items)); // equal ones count once
        items.addAll(WorldFileTest.parse(withConditions("c", 5000, 5001)).items());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> WorldWriter.write(withItems(items)))
                .withMessage(
                        "world w has 5001 different conditions and values in its actions, of which"
                                + " a world file holds 5000");
    }

    private static WorldDescription withItems(List<ItemDefinition> items)
            throws WorldFileException {
        WorldDescription world = WorldFileTest.parse("reve: 1\nname: w\n");
        return new WorldDescription(
                world.name(),
                world.doc(),
                world.prototype(),
                world.timing(),
                world.age(),
                world.laws(),
                world.constants(),
                world.camera(),
                world.agents(),
                world.rules(),
                world.ruleSteps(),
                items,
                world.forces(),
                world.warnings());
    }

    private static String withConditions(String item, int from, int to) {
        return "reve: 1\nname: w\nitems: [{name: "
                + item
                + ", access: {"
                + IntStream.range(0, (to - from + 49) / 50)
                        .mapToObj(
                                i ->
                                        "x%d: {when: [%s], effects: [{raise: e}]}"
                                                .formatted(
                                                        i,
                                                        IntStream.range(
                                                                        from + 50 * i,
                                                                        Math.min(
                                                                                to,
                                                                                from + 50 * i + 50))
                                                                .mapToObj(k -> "1 < " + (k + 2))
                                                                .collect(Collectors.joining(", "))))
                        .collect(Collectors.joining(", "))
                + "}}]\n";
    }

    @Test
    void writesWhatAWorldFileSays() throws WorldFileException {
        WorldDescription world =
                WorldFileTest.parse(
                        """
                        reve: 1
                        name: tiny
                        doc: "Two: bodies."
                        frame: {steps: 4}
                        properties:
                          - {name: heat, kind: body, unit: K, doc: How hot.}
                          - {name: cell, kind: body, type: i32, components: 2}
                        laws: [drag, {name: barnes_hut, parameters: {theta: 0.7, range: 2 km}}]
                        constants: {gravity: [0, -9.81, 0], softening: 0}
                        camera: {eye: [0, 1, 4], target: [0, 0, 0], fov: 90 deg}
                        agents: {bodies: [a], body: {physical: {shape: sphere, radius: 1 cm}}, items: 200,
                          worldItems: 7, eventBytes: 512, worldEventBytes: 1024, most: 12}
                        prefabs: {p: {physics: {mass: 2 g, cell: [1, -2]}}}
                        items:
                          - {name: a, like: p}
                          - {name: b, like: p, physics: {heat: 300}}
                          - {name: s, kind: spring, physics: {end1: b, end2: a, length: 3 cm}}
                          - {name: flag, parent: a, physical: {location: [0, 1, 0]}}
                        forces: [{item: b, force: 0 2 0 kN, frames: 12}]
                        """);

        assertThat(WorldWriter.write(world))
                .isEqualTo(
                        """
                        reve: 1
                        name: tiny
                        doc: 'Two: bodies.'
                        prototype: si-f64
                        properties:
                          - {name: heat, kind: body, unit: K, doc: How hot.}
                          - {name: cell, kind: body, type: i32, components: 2}
                        frame: {rate: 60, steps: 4}
                        laws:
                          - drag
                          - name: barnes_hut
                            parameters: {theta: 0.7, range: 2000}
                        constants: {gravity: [0, -9.81, 0]}
                        camera: {eye: [0, 1, 4], target: [0, 0, 0], up: [0, 1, 0], fov: 1.5707963267948966}
                        agents:
                          bodies: [a]
                          body:
                            physical: {shape: sphere, radius: 0.01}
                          worldItems: 7
                          eventBytes: 512
                          worldEventBytes: 1024
                          most: 12
                        items:
                          - name: a
                            physics: {mass: 0.002, cell: [1, -2]}
                          - name: b
                            physics: {mass: 0.002, heat: 300, cell: [1, -2]}
                          - name: s
                            kind: spring
                            physics: {length: 0.03, end1: b, end2: a}
                          - name: flag
                            parent: a
                            physical: {location: [0, 1, 0]}
                        forces:
                          - {item: b, force: [0, 2000, 0], frames: 12}
                        """);
    }

    @Test
    void randomWorldsAreReadBackToTheBit() throws WorldFileException {
        for (int n = 0; n < WORLDS; n++) {
            try (var arena = new OffHeapArena()) {
                WorldDescription begin = randomDescription(n);
                World live = begin.build(arena);
                change(live);
                WorldDescription now = begin.of(live, begin.laws());
                String written = WorldWriter.write(now);

                WorldDescription read = WorldFileTest.parse(written);

                String what = "seed " + seed + ", world " + n + "\n" + written;
                assertThat(WorldWriter.write(read)).as(what).isEqualTo(written);
                World again = read.build(arena);
                requireSameColumns(again, live, what);
                assertThat(WorldWriter.write(read.of(again, read.laws())))
                        .as(what)
                        .isEqualTo(written);
            }
        }
    }

    private WorldDescription randomDescription(int n) throws WorldFileException {
        WorldDescription shell =
                WorldFileTest.parse(
                        "reve: 1\nname: world "
                                + n
                                + "\nprototype: "
                                + (random.nextBoolean() ? "si-f32" : "si-f64")
                                + "\n"
                                + "properties: [{name: heat, kind: body, unit: mK}, {name: size_x,"
                                + " kind: lamp}]\n"
                                + "constants: {gravity: [0, "
                                + random.nextGaussian()
                                + ", -0.0]}\n");
        List<ItemDefinition> items = new ArrayList<>();
        for (int i = 0; i < random.nextInt(1, 12); i++) {
            items.add(RandomItems.body(random, shell.prototype(), "b" + i));
        }
        List<String> held =
                items.stream()
                        .filter(ItemDefinition::hasPhysics)
                        .map(ItemDefinition::name)
                        .toList();
        for (int i = 0; i < 4 && held.size() > 1; i++) {
            int end = random.nextInt(held.size());
            items.add(
                    random.nextInt(items.size()),
                    ItemDefinition.named("s" + i)
                            .kind("spring")
                            .physics("length", random.nextDouble())
                            .reference("end1", held.get(end))
                            .reference("end2", held.get((end + 1) % held.size()))
                            .build());
        }
        items.add(ItemDefinition.named("lamp").kind("lamp").physics("size_x", 0).build());
        List<LastingForce> forces =
                held.stream()
                        .filter(name -> random.nextBoolean())
                        .map(
                                name ->
                                        new LastingForce(
                                                name,
                                                List.of(force(shell), force(shell), force(shell)),
                                                1 + random.nextLong(Forces.MAX_FRAMES)))
                        .toList();
        return new WorldDescription(
                        shell.name(),
                        RandomItems.text(random),
                        shell.prototype(),
                        shell.timing(),
                        random.nextLong(1L << 40),
                        shell.laws(),
                        shell.constants(),
                        Optional.empty(),
                        AgentPolicy.none(),
                        List.of(),
                        20_000 + random.nextInt(2) * random.nextInt(1_000_000),
                        items,
                        forces,
                        List.of())
                .withThreads(1 + random.nextInt(3));
    }

    private double force(WorldDescription world) {
        return RandomItems.real(random, world.prototype());
    }

    /** Changes of a world: rows move, and children are attached. */
    private void change(World world) {
        for (Item item : world.items()) {
            if (item.kind().equals(WorldPrototype.BODY) && random.nextInt(4) == 0) {
                world.removeCascade(item.id());
            }
        }
        for (int i = 0; i < 3; i++) {
            world.add(ItemDefinition.named("late " + i).symbol("n", i).build());
        }
        Item child = world.find("late 0").orElseThrow();
        world.attach(child.id(), world.find("late 1").orElseThrow().id());
    }

    /** Rows that laws use must be in the same order. Scenery may be in another order. */
    private static void requireSameColumns(World world, World expected, String what) {
        for (Table table : expected.tables()) {
            Table other = world.table(table.kind());
            assertThat(other.rowCount()).as(what).isEqualTo(table.rowCount());
            assertThat(other.physicsRowCount()).as(what).isEqualTo(table.physicsRowCount());
            for (int row = 0; row < table.rowCount(); row++) {
                String name = expected.item(table.idAt(row)).name();
                int otherRow = other.rowOf(world.find(name).orElseThrow().id());
                if (row < table.physicsRowCount()) {
                    assertThat(otherRow).as("row of " + name + ", " + what).isEqualTo(row);
                }
                for (Column column : table.columns()) {
                    assertThat(values(world, other.column(column.name()), otherRow))
                            .as(column.name() + " of " + name + ", " + what)
                            .isEqualTo(values(expected, column, row));
                }
            }
        }
    }

    /** Returns the bits of numbers and the names of items. */
    private static List<Object> values(World world, Column column, int row) {
        List<Object> values = new ArrayList<>();
        for (int i = 0; i < column.components(); i++) {
            values.add(
                    column.type() == ScalarType.REF
                                    && row
                                            < world.table(column.descriptor().kind())
                                                    .physicsRowCount()
                            ? world.item(new ItemId(column.getReference(row, i))).name()
                            : column.type() == ScalarType.REF
                                    ? ""
                                    : Double.doubleToRawLongBits(column.getDouble(row, i)));
        }
        return values;
    }

    @Test
    void springsAndSurfacesKeepTheirLook() throws WorldFileException {
        String items =
                """
                  - name: red
                    kind: spring
                    physical: {colour: '#ff0000', width: 0.03}
                    physics: {length: 1, end1: a, end2: b}
                  - name: hidden
                    kind: spring
                    physical: {colour: '#ff000000'}
                    physics: {length: 1, end1: a, end2: b}
                  - name: cloth
                    kind: surface
                    physical: {colour: '#00ff00'}
                    physics: {vertices: [a, b, c]}
                """;
        WorldDescription world =
                WorldFileTest.parse(
                        """
                        reve: 1
                        name: w
                        prefabs:
                          rope: {physical: {colour: "#ff0000", width: 3 cm}, physics: {length: 1 m}}
                          cord: {physical: {width: 3 cm}}
                          thread: {physical: {colour: "#ff0000"}, physics: {length: 1 m}}
                        items:
                          - {name: a, physics: {mass: 1}}
                          - {name: b, physics: {mass: 1}}
                          - {name: c, physics: {mass: 1}}
                          - {name: red, kind: spring, like: rope, physics: {end1: a, end2: b}}
                          - {name: hidden, like: rope, kind: spring, physical: {colour: "#ff000000", width: 0},
                              physics: {end1: a, end2: b}}
                          - {name: cloth, kind: surface, physical: {colour: "#00ff00"},
                              physics: {vertices: [a, b, c]}}
                        """);
        String written = WorldWriter.write(world);
        assertThat(written).endsWith(items);
        assertThat(WorldWriter.write(WorldFileTest.parse(written))).isEqualTo(written);
    }
}
