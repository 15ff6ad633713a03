// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.assertj.core.data.Offset;
import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;

import java.lang.management.ManagementFactory;
import java.lang.management.ThreadMXBean;
import java.util.List;
import java.util.Map;

/** Items with parts: prefabs of several items. */
class GroupTest {
    private static final String START = "reve: 1\nname: w\n";
    private static final Offset<Double> ROUNDING = within(1e-15);
    private static final String TABLE =
            """
            prefabs:
              leg: {physical: {shape: sphere, radius: 1}, physics: {mass: 2}}
              table:
                parts:
                  top:
                    physical: {shape: box, size: [4, 1, 4], location: [0, 3, 0]}
                    physics: {mass: 20, velocity: [1, 0, 0]}
                  leg {i}:
                    like: leg
                    repeat: 2
                    physical: {location: "{[i, 0, 2]}"}
                  glue {i}:
                    kind: spring
                    repeat: 2
                    physics: {end1: top, end2: "leg {i}", length: 1}
                  lamp: {parent: top, physical: {location: [0, 1, 0]}}
            """;

    private static WorldDescription parse(String yaml) throws WorldFileException {
        return WorldFileTest.parse(START + yaml);
    }

    private static List<String> problems(String yaml) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> parse(yaml));
        assertThat(refused).as("refusal of\n%s", yaml).isNotNull();
        return refused.problems().stream().map(Problem::toString).toList();
    }

    private static ItemDefinition item(WorldDescription world, String name) {
        return world.items().stream()
                .filter(item -> item.name().equals(name))
                .findFirst()
                .orElseThrow(() -> new AssertionError(name));
    }

    @Test
    void partsAreItemsThatReferToEachOther() throws WorldFileException {
        WorldDescription world =
                parse(
                        TABLE
                                + """
                                items:
                                  - {name: desk, like: table, physical: {location: [10, 0, 0]}}
                                  - {name: leg 0, physical: {location: [0, 9, 0]}}
                                """);
        assertThat(world.items())
                .extracting(ItemDefinition::name)
                .containsExactly(
                        "desk.top",
                        "desk.leg 0",
                        "desk.leg 1",
                        "desk.glue 0",
                        "desk.glue 1",
                        "desk.lamp",
                        "leg 0");
        assertThat(item(world, "desk.top").location()).containsExactly(10, 3, 0);
        assertThat(item(world, "desk.leg 1").location()).containsExactly(11, 0, 2);
        assertThat(item(world, "desk.leg 1").physics("mass").orElseThrow()).containsExactly(2);
        assertThat(item(world, "desk.glue 1").references())
                .isEqualTo(Map.of("end1", List.of("desk.top"), "end2", List.of("desk.leg 1")));
        assertThat(item(world, "desk.lamp").parent()).hasValue("desk.top");
        assertThat(item(world, "desk.lamp").location()).containsExactly(0, 1, 0);
        assertThat(item(world, "desk.top").orientation()).containsExactly(0, 0, 0, 1);
    }

    /** A quarter turn around +Y takes +X to -Z, and +Z to +X. */
    @Test
    void aGroupTurnsPlacesAxesAndVelocities() throws WorldFileException {
        WorldDescription world =
                parse(
                        TABLE
                                + """
                                items:
                                  - name: desk
                                    like: table
                                    physical:
                                      location: 10 0 0 m
                                      orientation: {axis: [0, 1, 0], angle: 90 deg}
                                """);
        assertThat(item(world, "desk.leg 1").location())
                .containsExactly(new double[] {12, 0, -1}, ROUNDING);
        ItemDefinition top = item(world, "desk.top");
        double half = Math.sqrt(0.5);
        assertThat(top.orientation()).containsExactly(new double[] {0, half, 0, half}, ROUNDING);
        assertThat(top.physics("velocity").orElseThrow())
                .containsExactly(new double[] {0, 0, -1}, ROUNDING);
        assertThat(item(world, "desk.lamp").orientation()).containsExactly(0, 0, 0, 1);
    }

    @Test
    void groupsRepeatAndSingleItemsSetOtherValuesOfParts() throws WorldFileException {
        WorldDescription world =
                parse(
                        TABLE
                                + """
                                  low:
                                    like: table
                                    parts: {top: {physical: {location: [0, 1, 0]}}, vase: {parent: top}}
                                items:
                                  - name: "t{k}"
                                    like: table
                                    repeat: {k: 3}
                                    physical: {location: "{[10 * k, 0, 0]}"}
                                  - name: low
                                    like: low
                                    parts: {top: {physics: {mass: 7}}}
                                """);
        assertThat(world.items()).hasSize(3 * 6 + 7);
        assertThat(item(world, "t2.leg 1").location()).containsExactly(21, 0, 2);
        assertThat(item(world, "t2.glue 0").references())
                .containsEntry("end2", List.of("t2.leg 0"));
        assertThat(item(world, "low.top").location()).containsExactly(0, 1, 0);
        assertThat(item(world, "low.top").physics("mass").orElseThrow()).containsExactly(7);
        assertThat(item(world, "low.top").physics("velocity").orElseThrow())
                .containsExactly(1, 0, 0);
        assertThat(item(world, "low.vase").parent()).hasValue("low.top");
    }

    @Test
    void aPartMayBeAGroup() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        prefabs:
                          axle:
                            parts:
                              left: {physical: {location: [0, 0, 1]}, physics: {mass: 1}}
                              right: {physical: {location: [0, 0, -1]}, physics: {mass: 1}}
                              rod: {kind: spring, physics: {end1: left, end2: body}}
                          cart:
                            parts:
                              body: {physical: {location: [0, 1, 0]}, physics: {mass: 5}}
                              axle {i}:
                                like: axle
                                repeat: 2
                                physical: {location: "{[4 * i, 0, 0]}"}
                              tie: {kind: spring, physics: {end1: axle 0.left, end2: tower}}
                        items:
                          - {name: tower, physics: {mass: 1}}
                          - name: van
                            like: cart
                            physical: {location: [0, 0, 5], orientation: {axis: [0, 1, 0], angle: 180 deg}}
                        """);
        assertThat(item(world, "van.axle 1.left").location())
                .containsExactly(new double[] {-4, 0, 4}, ROUNDING);
        assertThat(item(world, "van.axle 1.rod").references())
                .isEqualTo(Map.of("end1", List.of("van.axle 1.left"), "end2", List.of("van.body")));
        assertThat(item(world, "van.tie").references())
                .isEqualTo(Map.of("end1", List.of("van.axle 0.left"), "end2", List.of("tower")));
    }

    @Test
    void mistakesInGroupsAreReportedAtTheirPlaces() {
        assertThat(
                        problems(
                                TABLE
                                        + """
                                        items:
                                          - {name: a, like: table, physics: {mass: 1}}
                                          - {name: b, like: table, physical: {colour: "#ffffff"}}
                                        """))
                .containsExactly(
                        "world.yaml:20:28: `physics` does not go with `parts`: a group has only a name and,"
                                + " in `physical`, a location and an orientation; write it into one"
                                + " of the parts",
                        "world.yaml:21:39: `colour` does not go with `parts`: a group has only a name and,"
                                + " in `physical`, a location and an orientation; write it into one"
                                + " of the parts");
        assertThat(problems("items: [{name: a, parts: {b: {physics: {masss: 1}}}}]"))
                .containsExactly(
                        "world.yaml:3:41: unknown physics property `masss` of kind body; did you mean"
                                + " `mass`?");
        assertThat(
                        problems(
                                "items: [{name: a, parts: {b: {kind: spring, physics: {end1: c, end2: d}}}}]"))
                .containsExactly(
                        "world.yaml:3:61: end1: no item is named `c`",
                        "world.yaml:3:70: end2: no item is named `d`");
        assertThat(problems("items: [{name: a, parts: {b: {}, c: {repeat: 2}}}]"))
                .singleElement()
                .asString()
                .startsWith(
                        "world.yaml:3:34: name: the item is repeated, so its name needs a formula");
        assertThat(problems("items: [{name: a, parts: {b: {name: c}}}]"))
                .singleElement()
                .asString()
                .startsWith("world.yaml:3:31: unknown key `name`");
        assertThat(problems("items: [{name: a, parts: {}}]"))
                .containsExactly(
                        "world.yaml:3:26: parts: found a mapping, expected at least 1 in it");
        assertThat(problems("items: [{name: a, parts: {b: {}}}, {name: a.b}]"))
                .containsExactly("world.yaml:3:43: duplicate item name `a.b`, first on line 3");
        assertThat(problems("prefabs: {p: {parts: {x: {like: p}}}}\nitems: [{name: a, like: p}]"))
                .singleElement()
                .asString()
                .contains("more than 8 groups", "a prefab cannot be a part of itself");
        assertThat(problems("prefabs: {p: {parts: {x: {}}}}\nagents: {body: {like: p}}"))
                .singleElement()
                .asString()
                .contains("body: is like a group of items, expected one item");
        assertThat(
                        problems(
                                "prefabs: {p: {parts: {x: {}}}}\n"
                                        + "items: [{name: a, access: {go: {effects: [{create: {name: b,"
                                        + " like: p}}]}}}]"))
                .singleElement()
                .asString()
                .contains("create: is a group of items, expected one item");
    }

    @Test
    void thePartsOfAPrefabThatNoItemUsesAreChecked() {
        assertThat(problems("prefabs: {p: {parts: {x: {physics: {mass: 3 m}}}}}"))
                .containsExactly("world.yaml:3:43: mass: unit m does not fit kg");
    }

    @Test
    void theNumberOfItemsOfGroupsIsLimited() {
        String prefabs =
                """
                prefabs:
                  p0: {physics: {mass: 1}}
                  p1: {parts: {"x{i}": {like: p0, repeat: 100000}}}
                  p2: {parts: {"y{i}": {like: p1, repeat: 900001}}}
                """;
        assertThat(problems(prefabs + "items: [{name: a, like: p2}]"))
                .containsExactly(
                        "world.yaml:7:9: more than 200000 parts of groups with their repetitions");
    }

    /** The groups of this file of 400 bytes would have 2,000,000 parts. */
    @Test
    void nestedGroupsAreCountedBeforeTheyAreExpanded() {
        StringBuilder prefabs = new StringBuilder("prefabs:\n");
        for (int level = 0; level < 6; level++) {
            prefabs.append(
                    "  l%d: {parts: {\"p {i}\": {like: l%d, repeat: 10}}}\n"
                            .formatted(level, level + 1));
        }
        prefabs.append("  l6: {physical: {shape: sphere, radius: 0.1}}\n");
        ThreadMXBean threads = ManagementFactory.getThreadMXBean();
        long least = Long.MAX_VALUE;
        for (int attempt = 0; attempt < 5 && least > 1_000_000_000; attempt++) {
            long begun = threads.getCurrentThreadCpuTime();
            assertThat(problems(prefabs + "items: [{name: \"g {n}\", repeat: {n: 2}, like: l0}]"))
                    .containsExactly(
                            "world.yaml:11:9: more than 200000 parts of groups with their"
                                    + " repetitions");
            least = Math.min(least, threads.getCurrentThreadCpuTime() - begun);
        }
        assertThat(least).as("processor time [ns]").isLessThan(1_000_000_000);
    }

    @Test
    void partsOfRepeatedGroupsAreCountedWithTheValuesOfTheItem() {
        String prefabs =
                """
                prefabs:
                  grid: {parts: {"x{i}": {physics: {mass: 1}, repeat: 10}}}
                """;
        assertThat(
                        problems(
                                prefabs
                                        + "items: [{name: a, like: grid, parts: {\"x{i}\":"
                                        + " {repeat: 200001}}}]"))
                .containsExactly(
                        "world.yaml:5:9: more than 200000 parts of groups with their repetitions");
    }

    @Test
    void anOperatorAddsAGroupToARunningWorld() throws Exception {
        WorldEdit edit =
                new EditReader(WorldPrototype.standard("si-f64"))
                        .add(
                                """
                                {"items": [{"name": "desk", "physical": {"location": [5, 0, 0]},
                                 "parts": {"top": {"physics": {"mass": 1}},
                                           "lamp": {"parent": "top"}}}]}
                                """,
                                new EditReader.Room());
        assertThat(((WorldEdit.Add) edit).items())
                .extracting(ItemDefinition::name)
                .containsExactly("desk.top", "desk.lamp");
        assertThat(((WorldEdit.Add) edit).items().getFirst().location()).containsExactly(5, 0, 0);
    }
}
