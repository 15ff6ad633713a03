// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemDefinition;
import reve.core.world.Shape;

import java.util.List;

/** Items that are like prefabs. */
class PrefabTest {
    private static final String START = "reve: 1\nname: w\n";

    private static WorldDescription parse(String yaml) throws WorldFileException {
        return WorldFileTest.parse(START + yaml);
    }

    private static List<String> problems(String yaml) {
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> parse(yaml));
        assertThat(refused).as("refusal of\n%s", yaml).isNotNull();
        return refused.problems().stream().map(Problem::toString).toList();
    }

    @Test
    void anItemSaysOnlyWhatIsDifferent() throws WorldFileException {
        List<ItemDefinition> items =
                parse(
                                """
                                prefabs:
                                  round:
                                    physical: {shape: sphere, radius: 30 cm}
                                    physics: {mass: 1}
                                  wheel:
                                    like: round
                                    physical: {colour: "#111111"}
                                    semantic: {class: wheel, worn: false}
                                    physics: {mass: 8 kg, inertia: [1, 1, 2]}
                                items:
                                  - {name: left, like: wheel, physical: {location: [-1, 0, 0]}}
                                  - name: right
                                    like: wheel
                                    physical: {location: [1, 0, 0]}
                                    semantic: {worn: true}
                                    physics: {inertia: [3, 3, 3]}
                                """)
                        .items();

        ItemDefinition left = items.getFirst();
        assertThat(left.shape()).isEqualTo(Shape.sphere(0.3));
        assertThat(left.colour()).hasToString("#111111ff");
        assertThat(left.location()).containsExactly(-1, 0, 0);
        assertThat(left.symbols()).containsEntry("class", "wheel").containsEntry("worn", false);
        assertThat(left.physics("mass").orElseThrow()).containsExactly(8);
        ItemDefinition right = items.getLast();
        assertThat(right.symbols()).containsEntry("class", "wheel").containsEntry("worn", true);
        assertThat(right.physics("mass").orElseThrow()).containsExactly(8);
        assertThat(right.physics("inertia").orElseThrow()).containsExactly(3, 3, 3);
    }

    @Test
    void prefabsGiveTheKindAndAgentsBodiesToo() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        prefabs:
                          rope: {kind: spring, physics: {springConstant: 5, end1: a}}
                          visitor: {physical: {shape: box, size: [1, 2, 1]}}
                        agents: {body: {like: visitor, physical: {colour: "#ff0000"}}}
                        items:
                          - {name: a, physics: {mass: 1}}
                          - {name: b, physics: {mass: 1}}
                          - {name: r, like: rope, physics: {end2: b}}
                        """);

        assertThat(world.items().getLast().kind()).isEqualTo("spring");
        assertThat(world.items().getLast().references())
                .containsEntry("end1", List.of("a"))
                .containsEntry("end2", List.of("b"));
        assertThat(world.agents().template().orElseThrow().shape()).isEqualTo(Shape.box(1, 2, 1));
    }

    @Test
    void whatIsWrongInAPrefabIsToldOnceWhereItStands() {
        assertThat(
                        problems(
                                """
                                prefabs:
                                  wheel:
                                    physics: {masss: 3, velocity: 1}
                                items:
                                  - {name: a, like: wheel}
                                  - {name: b, like: wheel, physics: {charge: 1 kg}}
                                """))
                .containsExactly(
                        "world.yaml:5:15: unknown physics property `masss` of kind body; did you"
                                + " mean `mass`?",
                        "world.yaml:5:35: velocity: found 1 number, expected 3 numbers in m/s",
                        "world.yaml:8:46: charge: unit kg does not fit C");
    }

    @Test
    void aPrefabIsCheckedForItsFormEvenIfNothingIsLikeIt() {
        assertThat(problems("prefabs: {wheel: {name: x, physics: 3}, 9: {}}\n"))
                .containsExactly(
                        "world.yaml:3:19: unknown key `name`; known here: like, kind, parent,"
                                + " physical, semantic, access, capabilities, physics, sensors, voice,"
                                + " parts, levels",
                        "world.yaml:3:37: physics: found number 3, expected a mapping",
                        "world.yaml:3:41: `9` is not a name; expected a letter, then letters,"
                                + " digits, - or _, at most 64 in all");
    }

    @Test
    void aPrefabThatIsNotThereIsNamed() {
        assertThat(problems("prefabs: {wheel: {}}\nitems: [{name: a, like: weel}]\n"))
                .containsExactly(
                        "world.yaml:4:25: like: there is no prefab `weel`; did you mean "
                                + "`wheel`?");
    }

    @Test
    void prefabsThatAreLikeEachOtherAreRefused() {
        assertThat(problems("prefabs:\n  a: {like: b}\n  b: {like: c}\n  c: {like: b}\n"))
                .containsExactly(
                        "world.yaml:6:13: like: prefabs are like each other in a circle: "
                                + "a, b, c, b");
        assertThat(problems("prefabs:\n  a: {like: a}\n"))
                .containsExactly(
                        "world.yaml:4:13: like: prefabs are like each other in a circle: a, a");
    }

    @Test
    void longChainsOfPrefabsAreRefused() {
        var yaml = new StringBuilder("prefabs:\n");
        for (int i = 0; i < 60_000; i++) {
            yaml.append("  p").append(i).append(": {like: p").append(i + 1).append("}\n");
        }
        assertThat(problems(yaml.toString()))
                .contains(
                        "world.yaml:35:15: like: more than 32 "
                                + "prefabs of which each is like the next");
    }

    @Test
    void hugePrefabsOfManyItemsAreRefusedBeforeTheyFillTheMemory() {
        var yaml = new StringBuilder("prefabs:\n  huge:\n    semantic:\n");
        for (int i = 0; i < 20_000; i++) {
            yaml.append("      s").append(i).append(": 1\n");
        }
        yaml.append("items:\n");
        for (int i = 0; i < 1000; i++) {
            yaml.append("  - {name: i").append(i).append(", like: huge}\n");
        }
        assertThat(problems(yaml.toString()))
                .contains(
                        "world.yaml:20506:5: more than 10000000 values in all items with what they"
                                + " are like and their repetitions");
    }

    @Test
    void agentsBodiesAreLikeBodiesOnly() {
        assertThat(problems("prefabs: {rope: {kind: spring}}\nagents: {body: {like: rope}}\n"))
                .containsExactly("world.yaml:4:16: body: is like a spring, expected a body");
    }
}
