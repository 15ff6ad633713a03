// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import java.util.stream.Collectors;

/** Substances of bodies: their masses, and their rows for laws. */
class SubstancesTest {
    private static WorldDescription parse(String items) throws WorldFileException {
        return WorldFile.parse(
                "w", ("reve: 1\nname: w\n" + items).getBytes(StandardCharsets.UTF_8));
    }

    private static ItemDefinition item(WorldDescription world, String name) {
        return world.items().stream()
                .filter(item -> item.name().equals(name))
                .findFirst()
                .orElseThrow();
    }

    private static double number(ItemDefinition item, String property) {
        return item.physics(property).orElse(new double[1])[0];
    }

    /** Returns the rows of substances: codes and values by the name of the item. */
    private static Map<String, List<Double>> rows(WorldDescription world) {
        Map<String, List<Double>> rows = new TreeMap<>();
        for (ItemDefinition item : world.items()) {
            if (item.kind().equals(WorldPrototype.SUBSTANCE_PAIR)) {
                double[] codes = item.physics("substances").orElseThrow();
                rows.put(
                        item.name(),
                        List.of(
                                codes[0],
                                codes[1],
                                number(item, "pairFriction"),
                                number(item, "pairRestitution")));
            }
        }
        return rows;
    }

    @Test
    void theMassIsDensityTimesVolumeUnlessTheItemStatesIt() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        prefabs:
                          cube: {physical: {shape: box, size: [0.1, 0.2, 0.5]}, physics: {substance: steel}}
                        items:
                          - {name: cube, like: cube}
                          - {name: large cube, like: cube, physical: {size: [0.2, 0.2, 0.5]}}
                          - {name: ball, physical: {shape: sphere, radius: 0.3}, physics: {substance: ice}}
                          - {name: light, like: cube, physics: {mass: 2 kg}}
                          - {name: oak, like: cube, physics: {substance: wood, density: 700 kg/m^3}}
                          - {name: wheel, like: cube, physics: {inertia: [1, 1, 1]}}
                          - {name: floor, physical: {shape: plane, size: [9, 9]}, physics: {substance: ice, mass: 0}}
                          - {name: part, parent: cube, physical: {shape: sphere, radius: 0.1}, physics: {substance: rubber, partOfBody: 1}}
                        """);
        assertThat(number(item(world, "cube"), "mass")).isCloseTo(78, within(1e-12));
        assertThat(item(world, "cube").physics("inertia").orElseThrow())
                .containsExactly(
                        new double[] {
                            78.0 / 12 * (0.04 + 0.25),
                            78.0 / 12 * (0.25 + 0.01),
                            78.0 / 12 * (0.01 + 0.04)
                        },
                        within(1e-12));
        assertThat(number(item(world, "large cube"), "mass")).isCloseTo(156, within(1e-12));
        assertThat(number(item(world, "ball"), "mass"))
                .isCloseTo(917 * 4 / 3.0 * Math.PI * 0.027, within(1e-9));
        assertThat(number(item(world, "ball"), "radius")).isEqualTo(0.3);
        assertThat(number(item(world, "light"), "mass")).isEqualTo(2);
        assertThat(item(world, "light").physics("inertia")).isEmpty();
        assertThat(number(item(world, "oak"), "mass")).isCloseTo(7, within(1e-12));
        assertThat(number(item(world, "wheel"), "mass")).isCloseTo(78, within(1e-12));
        assertThat(number(item(world, "wheel"), "inertia")).isEqualTo(1);
        assertThat(number(item(world, "floor"), "mass")).isZero();
        assertThat(number(item(world, "part"), "mass")).isZero();
        assertThat(number(item(world, "part"), "substance")).isEqualTo(7);
    }

    /** A saved world has the same masses, because it contains the codes of the substances. */
    @Test
    void planesAndTerrainsOfASubstanceAreImmovable() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        substances: {felt: {friction: 0.2}}
                        prefabs:
                          terrain: {physical: {shape: terrain, size: [2, 2], heights: [[0, 0], [0, 1]]}}
                        items:
                          - {name: plane, physical: {shape: plane, size: [9, 9]}, physics: {substance: ice}}
                          - {name: table, physical: {shape: plane, size: [9, 9]}, physics: {substance: felt}}
                          - {name: hill, like: terrain, physics: {substance: granite}}
                          - {name: sheet, physical: {shape: plane, size: [9, 9]}, physics: {substance: ice, mass: 3}}
                        """);
        assertThat(number(item(world, "plane"), "substance")).isEqualTo(6);
        assertThat(number(item(world, "hill"), "substance")).isEqualTo(9);
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        for (WorldDescription each : List.of(world, again)) {
            for (String name : List.of("plane", "table", "hill")) {
                assertThat(item(each, name).physics("mass").orElse(new double[1]))
                        .as(name)
                        .containsExactly(0);
                assertThat(item(each, name).hasPhysics()).as(name).isTrue();
            }
            assertThat(number(item(each, "sheet"), "mass")).isEqualTo(3);
        }
    }

    @Test
    void aWorldHasTheRowsOfTheSubstancesThatItUses() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        prefabs:
                          spare: {physical: {shape: box, size: [1, 1, 1]}, physics: {substance: copper}}
                        items:
                          - {name: puck, physical: {shape: sphere, radius: 1}, physics: {substance: steel}}
                          - {name: rink, physical: {shape: plane, size: [9, 9]}, physics: {substance: ice, mass: 0}}
                        """);
        assertThat(rows(world))
                .isEqualTo(
                        Map.of(
                                "substance steel", List.of(0.0, 2.0, 0.3, 0.56),
                                "substance copper", List.of(0.0, 4.0, 0.4, 0.4),
                                "substance ice", List.of(0.0, 6.0, 0.03, 0.3),
                                "substances steel copper", List.of(2.0, 4.0, 0.36, 0.0),
                                "substances steel ice", List.of(2.0, 6.0, 0.02, 0.0)));
        assertThat(number(item(world, "puck"), "substance")).isEqualTo(2);
        WorldDescription plain = parse("items: [{name: a, physics: {mass: 1}}]");
        assertThat(plain.prototype().kinds()).doesNotContain(WorldPrototype.SUBSTANCE_PAIR);
        assertThat(plain.prototype().hasSubstances()).isFalse();
    }

    @Test
    void aFileAddsSubstancesAndChangesShippedOnes() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        substances:
                          felt: {density: 200 kg/m^3, friction: 0, with: {steel: {friction: 0.2}, felt: {restitution: 0}}}
                          silk: {}
                          steel: {restitution: 0.9, with: {ice: {restitution: 0.4}}}
                        items:
                          - {name: hat, physical: {shape: box, size: [1, 1, 1]}, physics: {substance: felt}}
                          - {name: coat, physics: {substance: silk, mass: 1}}
                        """);
        double zero = Substances.STATED_ZERO;
        assertThat(number(item(world, "hat"), "mass")).isEqualTo(200);
        assertThat(rows(world))
                .isEqualTo(
                        Map.of(
                                "substance steel", List.of(0.0, 2.0, 0.3, 0.9),
                                "substance felt", List.of(0.0, 1001.0, zero, 0.0),
                                "substance silk", List.of(0.0, 1002.0, 0.0, 0.0),
                                "substances steel felt", List.of(2.0, 1001.0, 0.2, 0.0),
                                "substances felt felt", List.of(1001.0, 1001.0, 0.0, zero)));
    }

    @Test
    void ownFrictionNeedsNoDeclarationAndAStatedZeroIsKept() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        items:
                          - {name: puck, physics: {mass: 1, friction: 0, restitution: 0.4}}
                          - {name: other, physics: {mass: 1}}
                        """);
        assertThat(number(item(world, "puck"), "friction")).isEqualTo(Substances.STATED_ZERO);
        assertThat(number(item(world, "puck"), "restitution")).isEqualTo(0.4);
        assertThat(world.prototype().hasSubstances()).isTrue();
        WorldDescription declared =
                parse(
                        """
                        properties: [{name: friction, kind: body, min: 0}]
                        items: [{name: puck, physics: {mass: 1, friction: 0}}]
                        """);
        assertThat(number(item(declared, "puck"), "friction")).isZero();
        assertThat(declared.prototype().hasSubstances()).as("as before substances").isFalse();
    }

    private static double[] arms(WorldDescription world, String row) {
        return new double[] {
            number(item(world, row), "pairRollingFriction"),
            number(item(world, row), "pairSpinFriction")
        };
    }

    @Test
    void substancesAndPairsMayResistRollingAndSpinning() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        substances:
                          felt: {rollingFriction: 0.4 mm, with: {ivory: {spinFriction: 0.8 mm}, steel: {rollingFriction: 0}}}
                          ivory: {density: 1700, spinFriction: 1 cm}
                          steel: {spinFriction: 2 mm}
                        items:
                          - {name: table, physical: {shape: plane, size: [9, 9]}, physics: {substance: felt, mass: 0}}
                          - {name: ball, physical: {shape: sphere, radius: 0.1}, physics: {substance: ivory, rollingFriction: 0, spinFriction: 3 mm}}
                        """);
        assertThat(arms(world, "substance felt")).containsExactly(0.0004, 0);
        assertThat(arms(world, "substance ivory")).containsExactly(0, 0.01);
        assertThat(arms(world, "substance steel")).containsExactly(0, 0.002);
        assertThat(arms(world, "substances felt ivory")).containsExactly(0, 0.0008);
        assertThat(arms(world, "substances steel felt")).containsExactly(Substances.STATED_ZERO, 0);
        assertThat(number(item(world, "substance steel"), "pairFriction"))
                .as("as shipped")
                .isEqualTo(0.3);
        assertThat(number(item(world, "ball"), "rollingFriction"))
                .isEqualTo(Substances.STATED_ZERO);
        assertThat(number(item(world, "ball"), "spinFriction")).isEqualTo(0.003);
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(WorldWriter.write(again)).isEqualTo(WorldWriter.write(world));
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
    }

    /** Worlds keep their columns, and with them their images, and the meaning of a value 0. */
    @Test
    void aWorldHasTheResistancesThatItsSubstancesState() throws WorldFileException {
        WorldDescription none =
                parse(
                        """
                        substances: {felt: {friction: 1}}
                        items: [{name: ball, physics: {mass: 1, rollingFriction: 0}}]
                        """);
        assertThat(none.prototype().find(WorldPrototype.SUBSTANCE_PAIR, "pairRollingFriction"))
                .isEmpty();
        assertThat(none.prototype().find(WorldPrototype.SUBSTANCE_PAIR, "pairSpinFriction"))
                .isEmpty();
        assertThat(number(item(none, "ball"), "rollingFriction")).isZero();
        WorldDescription one = parse("substances: {felt: {with: {ice: {spinFriction: 1 mm}}}}");
        assertThat(one.prototype().find(WorldPrototype.SUBSTANCE_PAIR, "pairRollingFriction"))
                .isEmpty();
        assertThat(one.prototype().find(WorldPrototype.SUBSTANCE_PAIR, "pairSpinFriction"))
                .isPresent();
    }

    @Test
    void aSavedWorldIsReadBackToTheBit() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        substances: {felt: {density: 200, with: {ice: {friction: 0.2}}}}
                        agents:
                          body: {physical: {shape: sphere, radius: 0.5}, physics: {substance: rubber}}
                        items:
                          - {name: puck, physical: {shape: sphere, radius: 1}, physics: {substance: felt, friction: 0}}
                          - {name: rink, physical: {shape: plane, size: [9, 9]}, physics: {substance: ice, mass: 0}}
                        """);
        WorldDescription again = WorldFileTest.parse(WorldWriter.write(world));
        assertThat(WorldWriter.write(again)).isEqualTo(WorldWriter.write(world));
        assertThat(again.items()).hasSameSizeAs(world.items());
        assertThat(again.prototype().properties()).isEqualTo(world.prototype().properties());
        assertThat(rows(world)).containsKey("substance rubber");
        String saved =
                WorldWriter.write(parse("items: [{name: a, physics: {mass: 1, substance: 0}}]"));
        assertThat(WorldFileTest.parse(saved).prototype().hasSubstances()).isTrue();
    }

    @Test
    void problemsNameTheSubstanceAndTheRemedy() {
        assertProblem(
                "items: [{name: a, physical: {shape: sphere, radius: 1}, physics: {substance: stel}}]",
                "w:3:78: substance: there is no substance `stel`; did you mean `steel`?");
        assertProblem(
                "items: [{name: a, physics: {substance: quicksilver, mass: 1}}]",
                "substance: there is no substance `quicksilver`; known are");
        assertProblem(
                "items: [{name: a, physical: {shape: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 0, 1]],"
                        + " triangles: [[0, 1, 2]]}, physics: {substance: ice}}]",
                "substance: no mass follows from the density of ice: ");
        assertProblem(
                "items: [{name: a, physics: {substance: ice}}]",
                "substance: no mass follows from the density of ice: without a shape it has no"
                        + " volume; or state the `mass`, which is 0 for an immovable body");
        assertProblem(
                "substances: {silk: {}}\n"
                        + "items: [{name: a, physical: {shape: sphere, radius: 1}, physics: {substance:"
                        + " silk}}]",
                "substance: the substance `silk` has no density; state it under `substances`");
        assertProblem(
                "substances: {silk: {density: 0}}", "density: found 0.0, expected more than 0");
        assertProblem(
                "substances: {silk: {restitution: 1.5}}",
                "restitution: found 1.5, expected 0 to 1.0");
        assertProblem("substances: {silk: {frction: 1}}", "did you mean `friction`?");
        assertProblem(
                "substances: {silk: {rollingFriction: -1 mm}}",
                "rollingFriction: found -0.001, expected 0 to 1000.0");
        assertProblem(
                "substances: {silk: {spinFriction: 1 kg}}", "spinFriction: unit kg does not fit m");
        assertProblem(
                "substances: {silk: {with: {stel: {friction: 1}}}}",
                "with: there is no substance `stel`; did you mean `steel`?");
        assertProblem(
                "substances: {a: {with: {b: {friction: 1}}}, b: {with: {a: {friction: 2}}}}",
                "with: the pair of `b` and `a` has its values already on line 3");
        assertProblem(
                "items: [{name: substance ice, physics: {substance: ice, mass: 1}}]",
                "an item has the name `substance ice`, which the world needs for a substance");
    }

    private static void assertProblem(String text, String message) {
        assertThatThrownBy(() -> parse(text)).hasMessageContaining(message);
    }

    @Test
    void anEditAddsTheRowsThatTheWorldLacks() throws Exception {
        WorldDescription description =
                parse(
                        """
                        items:
                          - {name: rink, physical: {shape: plane, size: [9, 9]}, physics: {substance: ice, mass: 0}}
                        """);
        try (var arena = new OffHeapArena()) {
            World world = description.build(arena);
            var reader = new EditReader(world.prototype());
            String text =
                    """
                    {"items": [{"name": "NAME", "physical": {"shape": "sphere", "radius": 0.5},
                      "physics": {"substance": "steel"}}]}
                    """;
            for (String name : List.of("puck", "second puck")) {
                WorldEdit edit = reader.add(text.replace("NAME", name), new EditReader.Room());
                WorldEdit.make(world, 1, List.of(edit), Set.of(), () -> {});
            }
            assertThat(world.find("second puck").orElseThrow().physics().scalar("mass"))
                    .isCloseTo(7800 * Math.PI / 6, within(1e-9));
            assertThat(
                            world.find("substances steel ice")
                                    .orElseThrow()
                                    .physics()
                                    .scalar("pairFriction"))
                    .isEqualTo(0.02);
            WorldEdit change =
                    reader.change("puck", "body", "{\"physics\": {\"substance\": \"cork\"}}");
            WorldEdit rain =
                    reader.change(
                            "substances steel ice",
                            WorldPrototype.SUBSTANCE_PAIR,
                            "{\"physics\": {\"pairFriction\": 0.5}}");
            WorldEdit.make(world, 1, List.of(change, rain), Set.of(), () -> {});
            assertThat(
                            world.find("substances steel ice")
                                    .orElseThrow()
                                    .physics()
                                    .scalar("pairFriction"))
                    .isEqualTo(0.5);
            assertThat(world.find("puck").orElseThrow().physics().scalar("substance"))
                    .isEqualTo(11);
            assertThat(world.find("puck").orElseThrow().physics().scalar("mass"))
                    .as("not changed")
                    .isCloseTo(7800 * Math.PI / 6, within(1e-9));
        }
    }

    /** The tables of the page list the shipped values. */
    @Test
    void thePageListsTheShippedSubstances() throws IOException {
        String page = Files.readString(WorldFileTest.root().resolve("docs/substances.md"));
        List<String> found = new ArrayList<>();
        Matcher row =
                Pattern.compile(
                                "^\\| `(\\w+)` \\| (\\S+) \\(.\\) \\| (\\S+) \\(.\\) \\| (\\S+) \\(.\\) \\|$",
                                Pattern.MULTILINE)
                        .matcher(page);
        while (row.find()) {
            found.add(
                    "%s %s %s %s"
                            .formatted(
                                    row.group(1),
                                    Double.parseDouble(row.group(2)),
                                    Double.parseDouble(row.group(3)),
                                    Double.parseDouble(row.group(4))));
        }
        assertThat(found)
                .isEqualTo(
                        Substances.shipped().all().stream()
                                .map(
                                        one ->
                                                "%s %s %s %s"
                                                        .formatted(
                                                                one.name(),
                                                                one.density().getAsDouble(),
                                                                one.contact()
                                                                        .friction()
                                                                        .getAsDouble(),
                                                                one.contact()
                                                                        .restitution()
                                                                        .getAsDouble()))
                                .toList());
        Map<Integer, String> names =
                Substances.shipped().all().stream()
                        .collect(
                                Collectors.toMap(
                                        Substances.Substance::code, Substances.Substance::name));
        Set<String> pairs = new TreeSet<>();
        Matcher pair =
                Pattern.compile(
                                "^\\| `(\\w+)` on `(\\w+)` \\| (\\S+) \\(.\\) \\|$",
                                Pattern.MULTILINE)
                        .matcher(page);
        while (pair.find()) {
            pairs.add(
                    Set.of(pair.group(1), pair.group(2)).stream()
                                    .sorted()
                                    .collect(Collectors.joining(" "))
                            + " "
                            + Double.parseDouble(pair.group(3)));
        }
        Set<String> shipped = new TreeSet<>();
        Substances.shipped()
                .pairs()
                .forEach(
                        (codes, contact) ->
                                shipped.add(
                                        List.of(names.get(codes.first()), names.get(codes.second()))
                                                        .stream()
                                                        .sorted()
                                                        .collect(Collectors.joining(" "))
                                                + " "
                                                + contact.friction().getAsDouble()));
        assertThat(pairs).isEqualTo(shipped).hasSize(9);
    }
}
