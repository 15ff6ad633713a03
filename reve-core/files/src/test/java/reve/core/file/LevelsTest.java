// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.image.WorldDigest;
import reve.core.level.LevelKeeper;
import reve.core.world.Action;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Level;
import reve.core.world.LevelChange;
import reve.core.world.LevelCondition;
import reve.core.world.OffHeapArena;
import reve.core.world.World;
import reve.core.world.WorldEvent;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Set;

/** Items with levels: in world files, in saved worlds, in edits, in actions and by conditions. */
class LevelsTest {
    private static final String START = "reve: 1\nname: w\n";
    private static final String DROP =
            """
            prefabs:
              jelly:
                parts:
                  knot {i}:
                    repeat: 4
                    physical: {location: "{[i - 1.5, i % 2, 0.5 * i]}"}
                    physics: {mass: 0.25, velocity: [0, 0, 7]}
                  string {i}:
                    kind: spring
                    repeat: 3
                    physics: {end1: "knot {i}", end2: "knot {i+1}", length: 1}
                  skin: {parent: knot 2, physical: {shape: sphere, radius: 0.1}}
              drop:
                levels:
                  ball:
                    physical: {shape: sphere, radius: 0.5, colour: "#ff0000"}
                    physics: {density: 1.909859317102744, velocity: [0, 0, 7]}
                    when: norm(velocity) < 1.0 && vibration < 0.01
                  soft: {like: jelly, when: norm(velocity) > 5.0}
            """;

    private final OffHeapArena arena = new OffHeapArena();
    private final List<WorldEvent> events = new ArrayList<>();

    @AfterEach
    void close() {
        arena.close();
    }

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

    private static List<String> names(WorldDescription world) {
        return world.items().stream().map(ItemDefinition::name).toList();
    }

    @Test
    void theFirstLevelIsActiveUnlessTheSymbolNamesAnother() throws WorldFileException {
        WorldDescription world =
                parse(
                        DROP
                                + """
                                items:
                                  - {name: a, like: drop, physical: {location: [10, 0, 0]}}
                                  - name: b
                                    like: drop
                                    physical: {location: [20, 0, 0], orientation: {axis: [0, 1, 0], angle: 90 deg}}
                                    semantic: {level: soft, class: toy}
                                """);
        assertThat(names(world))
                .containsExactly(
                        "a",
                        "b",
                        "b.knot 0",
                        "b.knot 1",
                        "b.knot 2",
                        "b.knot 3",
                        "b.string 0",
                        "b.string 1",
                        "b.string 2",
                        "b.skin");
        ItemDefinition a = item(world, "a");
        assertThat(a.location()).containsExactly(10, 0, 0);
        assertThat(a.physics("mass").orElseThrow()[0]).isCloseTo(1, within(1e-12));
        assertThat(a.symbols()).containsEntry("level", "ball");
        assertThat(a.levels()).extracting(Level::name).containsExactly("ball", "soft");
        ItemDefinition b = item(world, "b");
        assertThat(b.hasPhysics()).isFalse();
        assertThat(b.parent()).contains("b.knot 0");
        assertThat(b.symbols()).containsEntry("level", "soft").containsEntry("class", "toy");
        assertThat(item(world, "b.knot 3").physics("velocity").orElseThrow()[0])
                .isCloseTo(7, within(1e-14));
        assertThat(item(world, "b.skin").parent()).contains("b.knot 2");

        World built = world.build(arena);
        Item item = built.find("b").orElseThrow();
        assertThat(item.physical().location())
                .usingComparatorWithPrecision(1e-12)
                .containsExactly(20, 0, 0);
        assertThat(item.level().orElseThrow().items().getFirst().name()).isEqualTo("knot 0");
    }

    @Test
    void eachRepetitionHasItsOwnParts() throws WorldFileException {
        assertThat(
                        names(
                                parse(
                                        DROP
                                                + "items: [{name: 'd{k}', like: drop, repeat: {k: 2},"
                                                + " semantic: {level: soft}, physical: {location:"
                                                + " '{[5 * k, 0, 0]}'}}]")))
                .contains("d0", "d1", "d0.knot 3", "d1.knot 3", "d1.string 2");
    }

    @Test
    void aPartOfAGroupMayHaveLevels() throws WorldFileException {
        WorldDescription world =
                parse(
                        DROP
                                + """
                                items:
                                  - name: van
                                    physical: {location: [0, 0, 5]}
                                    parts:
                                      tyre: {like: drop, semantic: {level: soft}, physical: {location: [1, 0, 0]}}
                                """);
        assertThat(names(world)).contains("van.tyre", "van.tyre.knot 0");
        assertThat(item(world, "van.tyre.knot 0").location()).containsExactly(-0.5, 0, 5);
    }

    /** All levels without parts: the item always has physics, so a spring may end at it. */
    @Test
    void otherItemsMayReferToAnItemWhoseLevelsHaveNoParts() throws WorldFileException {
        WorldDescription world =
                parse(
                        """
                        items:
                          - name: bead
                            levels:
                              ball: {physical: {shape: sphere, radius: 1}, physics: {mass: 2, inertia: [1, 1, 1]}}
                              point: {physics: {mass: 2}}
                          - {name: hook, physics: {mass: 0}}
                          - {name: rope, kind: spring, physics: {end1: hook, end2: bead}}
                        """);
        assertThat(names(world)).containsExactly("bead", "hook", "rope");
    }

    @Test
    void problemsAreReportedAtTheirPlace() {
        assertThat(
                        problems(
                                """
                                items:
                                  - name: a
                                    levels:
                                      ball: {physics: {mass: 1}, when: norm(velocity)}
                                      light: {physics: {mass: 0.9}, when: norm(velocityy) > 3.0}
                                      far: {physics: {mass: 1}, physical: {location: [1, 0, 0]}}
                                      net:
                                        parts:
                                          one: {physics: {mass: 1}}
                                          two: {kind: spring, physics: {end1: one, end2: hook}}
                                      dust: {parts: {one: {physics: {charge: 1}}}}
                                    semantic: {level: bal}
                                  - {name: hook, physics: {mass: 0}}
                                """))
                .containsExactly(
                        "world.yaml:6:40: when: is a number, expected true or false",
                        "world.yaml:7:7: light: has the mass 0.9 kg, but the level `ball` has 1 kg; expected the"
                                + " same mass, within a thousandth of it",
                        "world.yaml:7:48: when: unknown name `velocityy`; known are angularVelocity,"
                                + " energy, item, location, mass, physical, physics, semantic, velocity,"
                                + " vibration",
                        "world.yaml:8:44: `location` does not belong to a level; write it into `physical` of the"
                                + " item",
                        "world.yaml:12:58: end2: no item is named `hook`",
                        "world.yaml:13:7: level dust: its part one has no mass; expected a mass above 0, or a"
                                + " parent with which the part moves",
                        "world.yaml:14:23: level: the item has no level `bal`; did you mean `ball`?");
        assertThat(
                        problems(
                                """
                                items:
                                  - name: a
                                    physical: {shape: sphere, radius: 1}
                                    levels:
                                      ball: {physics: {mass: 1}}
                                      soft: {parts: {core: {physics: {mass: 1}}}}
                                  - {name: rope, kind: spring, physics: {end1: a, end2: a.core}}
                                  - {name: a.core}
                                """))
                .containsExactly(
                        "world.yaml:5:16: `shape` does not go with `levels`: beside them, `physical` has only a"
                                + " location and an orientation; write it into the levels",
                        "world.yaml:5:31: `radius` does not go with `levels`: beside them, `physical` has only a"
                                + " location and an orientation; write it into the levels",
                        "world.yaml:9:48: end1: `a` has a level with parts, so it does not always have physics;"
                                + " expected an item whose levels have no parts",
                        "world.yaml:9:57: end2: `a.core` is a part of a level of `a`, which leaves with this"
                                + " level; only parts of the same level can refer to it",
                        "world.yaml:10:12: duplicate item name `a.core`, first on line 4");
    }

    @ParameterizedTest
    @ValueSource(
            strings = {
                "{name: a, kind: spring, levels: {x: {physics: {mass: 1}}, y: {physics: {mass: 1}}}}",
                "{name: a, parts: {p: {}}, levels: {x: {physics: {mass: 1}}, y: {physics: {mass: 1}}}}",
                "{name: a, levels: {x: {physics: {mass: 1}}}}",
                "{name: a, levels: {x: {physics: {mass: 1}}, y: {parts: {p: {physics: {mass: 1}, levels:"
                        + " {x: {physics: {mass: 1}}, y: {physics: {mass: 1}}}}}}}}",
                "{name: a, access: {go: {effects: [{create: {name: b, levels: {x: {physics: {mass: 1}},"
                        + " y: {physics: {mass: 1}}}}}]}}}"
            })
    void levelsWhereTheyDoNotBelongAreRefused(String item) {
        assertThat(problems("items: [" + item + "]").toString()).contains("levels");
    }

    /** The largest level can be stored and read again, and a larger one is refused. */
    @Test
    void aLevelHasOneThousandPartsAtMost() throws Exception {
        String world =
                """
                items:
                  - name: a
                    levels:
                      ball: {physics: {mass: 1}}
                      soft:
                        parts:
                          core: {physics: {mass: 1}}
                          "p{i}": {repeat: %d, parent: core}
                """;
        assertThat(problems(world.formatted(1000)))
                .containsExactly(
                        "world.yaml:7:7: soft: has 1001 parts with their repetitions, expected at most"
                                + " 1000");
        WorldDescription largest = parse(world.formatted(999));
        var writer = new ItemWriter(largest.prototype());
        ItemDefinition a = item(largest, "a");
        ItemDefinition read = WorldFile.parseItem("a", writer.write(a), largest.prototype());
        assertThat(read.levels().getLast().items()).hasSize(1000);
        assertThat(writer.write(read)).isEqualTo(writer.write(a));
        String text = WorldWriter.write(largest);
        assertThat(WorldFile.parse("saved", text.getBytes(StandardCharsets.UTF_8)).items())
                .hasSize(1);
    }

    /** A saved world continues with the active level, and the same bits. */
    @ParameterizedTest
    @ValueSource(strings = {"ball", "soft"})
    void aSavedWorldKeepsTheActiveLevel(String level) throws Exception {
        for (String prototype : List.of("si-f64", "si-f32")) {
            WorldDescription first =
                    parse(
                            "prototype: "
                                    + prototype
                                    + "\n"
                                    + DROP
                                    + "items: [{name: a, like: drop, physical: {location: [0.1, 0, 0],"
                                    + " orientation: {axis: [1, 1, 0], angle: 0.3}}}]");
            World world = first.build(arena);
            change(world, "a", level);
            String text = WorldWriter.write(first.of(world, List.of()));
            WorldDescription saved =
                    WorldFile.parse("saved", text.getBytes(StandardCharsets.UTF_8));
            assertThat(WorldWriter.write(saved.of(saved.build(arena), List.of()))).isEqualTo(text);
            World again = saved.build(arena);
            assertThat(digest(again)).isEqualTo(digest(world));
            String other = level.equals("ball") ? "soft" : "ball";
            change(world, "a", other);
            change(again, "a", other);
            assertThat(digest(again)).isEqualTo(digest(world));
        }
    }

    private static List<Long> digest(World world) {
        var digest = new WorldDigest(world);
        long[] parts = new long[digest.size()];
        digest.compute(parts);
        return Arrays.stream(parts).boxed().toList();
    }

    private static void change(World world, String item, String level) throws Exception {
        WorldEdit.make(
                world,
                3,
                List.of(
                        new EditReader(world.prototype())
                                .change(item, "body", "semantic: {level: " + level + "}")),
                Set.of(),
                () -> {});
    }

    @Test
    void anEditChangesTheLevelOrNothing() throws Exception {
        World world = parse(DROP + "items: [{name: a, like: drop}]").build(arena);
        change(world, "a", "soft");
        assertThat(world.find("a.knot 0")).isPresent();
        assertThat(world.events().getLast().fields()).containsEntry("to", "soft");
        List<Long> before = digest(world);
        assertThatThrownBy(() -> change(world, "a", "hard"))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("has no level hard; its levels are ball, soft");
        assertThatThrownBy(
                        () ->
                                WorldEdit.make(
                                        world,
                                        3,
                                        List.of(
                                                new EditReader(world.prototype())
                                                        .change(
                                                                "a",
                                                                "body",
                                                                "semantic: {level: ball}"),
                                                new WorldEdit.Remove("nobody", false)),
                                        Set.of(),
                                        () -> {}))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("nobody");
        assertThat(digest(world)).isEqualTo(before);
        WorldEdit more =
                new EditReader(world.prototype())
                        .add(DROP + "items: [{name: b, like: drop}]", new EditReader.Room());
        WorldEdit.make(world, 4, List.of(more), Set.of(), () -> {});
        change(world, "b", "soft");
        assertThat(world.find("b.knot 3")).isPresent();
    }

    /** Each change of a level counts with its parts, so that no message stops the world. */
    @Test
    void oneMessageChangesLevelsOfTenThousandPartsAtMost() throws Exception {
        World world =
                parse(
                                """
                                items:
                                  - name: a
                                    levels:
                                      ball: {physics: {mass: 1}}
                                      soft: {parts: {"p{i}": {repeat: 1000, physics: {mass: 0.001}}}}
                                """)
                        .build(arena);
        var reader = new EditReader(world.prototype());
        List<WorldEdit> edits = new ArrayList<>();
        for (String level : List.of("soft", "ball")) {
            edits.add(reader.change("a", "body", "semantic: {level: " + level + "}"));
        }
        List<WorldEdit> many = new ArrayList<>();
        for (int i = 0; i < 5; i++) {
            many.addAll(edits);
        }
        WorldEdit.make(world, 3, many, Set.of(), () -> {});
        many.addAll(edits);
        assertThatThrownBy(() -> WorldEdit.make(world, 3, many, Set.of(), () -> {}))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining(
                        "edit 11 of 12: the levels that one message changes have more");
        List<WorldEdit> withNew = new ArrayList<>();
        withNew.add(
                reader.add(
                        """
                        items:
                          - name: b
                            levels:
                              ball: {physics: {mass: 1}}
                              soft: {parts: {"p{i}": {repeat: 1000, physics: {mass: 0.001}}}}
                        """,
                        new EditReader.Room()));
        for (int i = 0; i < 11; i++) {
            String level = i % 2 == 0 ? "soft" : "ball";
            withNew.add(reader.change("b", "body", "semantic: {level: " + level + "}"));
        }
        assertThatThrownBy(() -> WorldEdit.make(world, 3, withNew, Set.of(), () -> {}))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("edit 12 of 12");
        assertThat(world.find("b")).isEmpty();
    }

    /** An action may need the physics that the item has at another level. */
    @Test
    void aSavedLevelWithPartsKeepsTheActionsOfTheOthers() throws Exception {
        WorldDescription first =
                parse(
                        DROP
                                + """
                                items:
                                  - name: a
                                    like: drop
                                    access:
                                      heat: {effects: [{set: physics.charge, to: 1}]}
                                      kick: {effects: [{impulse: [0, 0, 1]}]}
                                """);
        World world = first.build(arena);
        change(world, "a", "soft");
        String text = WorldWriter.write(first.of(world, List.of()));
        WorldDescription saved = WorldFile.parse("saved", text.getBytes(StandardCharsets.UTF_8));
        assertThat(item(saved, "a").actions()).hasSize(2);
    }

    /** The action also changes the velocity first, which the new level takes over. */
    @Test
    void anActionChangesTheLevelOrNothing() throws Exception {
        World world =
                parse(
                                DROP
                                        + """
                                        items:
                                          - name: a
                                            like: drop
                                            access:
                                              soften:
                                                parameters: {how: {type: text}}
                                                effects:
                                                  - {symbol: level, to: $how}
                                                  - {impulse: [0, 2, -7]}
                                        """)
                        .build(arena);
        Item a = world.find("a").orElseThrow();
        List<Long> before = digest(world);
        assertThatThrownBy(() -> soften(world, a, "liquid"))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("has no level liquid")
                .extracting(refused -> ((ActionRefused) refused).code())
                .isEqualTo("not-a-level");
        assertThat(digest(world)).isEqualTo(before);
        soften(world, a, "soft");
        assertThat(world.events().getLast().type()).isEqualTo("level-changed");
        assertThat(world.find("a.knot 1").orElseThrow().physics().vector("velocity"))
                .usingComparatorWithPrecision(1e-14)
                .containsExactly(0, 2, 0);
    }

    private static void soften(World world, Item item, String level) throws ActionRefused {
        perform(world, item, "soften", Map.of("how", level));
    }

    private static void perform(World world, Item item, String name, Map<String, Object> arguments)
            throws ActionRefused {
        Action action = item.access().find(name).orElseThrow();
        new ActionCall(world, 1, item, Optional.empty(), Arguments.check(action, arguments))
                .perform(action);
    }

    /** Effects that could make the prepared change impossible do not go with it. */
    @ParameterizedTest
    @ValueSource(
            strings = {
                "{remove: true}",
                "{create: {name: new}}",
                "{item: other, symbol: level, to: soft}",
                "{set: physics.mass, to: 0}"
            })
    void anActionThatCannotDoAllItsEffectsDoesNone(String effect) throws Exception {
        World world =
                parse(
                                """
                                prefabs:
                                  drop:
                                    levels:
                                      ball: {physics: {mass: 0.001}}
                                      soft: {parts: {core: {physics: {mass: 0.001}}}}
                                items:
                                  - {name: b, like: drop}
                                  - name: a
                                    like: drop
                                    access:
                                      go:
                                        parameters: {other: {type: item}}
                                        effects: [%s, {symbol: level, to: soft}]
                                """
                                        .formatted(effect))
                        .build(arena);
        List<Long> before = digest(world);
        Item a = world.find("a").orElseThrow();
        assertThatThrownBy(() -> perform(world, a, "go", Map.of("other", "b")))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("can change only symbols, colours and velocities")
                .extracting(refused -> ((ActionRefused) refused).code())
                .isEqualTo("not-a-level");
        assertThat(digest(world)).isEqualTo(before);
    }

    /** Each part that leaves or enters costs steps, and the event counts as well. */
    @Test
    void aChangeCostsAsMuchAsItsParts() throws Exception {
        World world =
                parse(
                                DROP
                                        + """
                                        items:
                                          - name: a
                                            like: drop
                                            access:
                                              paint: {effects: [{symbol: level, to: ball}]}
                                              soften: {effects: [{symbol: level, to: soft}]}
                                        """)
                        .build(arena);
        Item a = world.find("a").orElseThrow();
        long begin = world.activity().steps();
        perform(world, a, "soften", Map.of());
        long there = world.activity().steps() - begin;
        perform(world, a, "paint", Map.of());
        assertThat(there)
                .isGreaterThanOrEqualTo(LevelChange.STEPS + 8 * LevelChange.STEPS_PER_PART);
        assertThat(world.activity().steps() - begin - there).isEqualTo(there);
        assertThat(world.events())
                .allSatisfy(
                        event ->
                                assertThat(event.bytes())
                                        .isLessThanOrEqualTo(LevelChange.EVENT_BYTES));
    }

    /**
     * While a level with parts is active, no other change attaches or detaches the item: its parts
     * would be lost, or another item would be taken for a part.
     */
    @Test
    void anItemAtALevelWithPartsStaysAttachedToItsPart() throws Exception {
        World world =
                parse(
                                DROP
                                        + """
                                        items:
                                          - {name: hand}
                                          - name: a
                                            like: drop
                                            semantic: {level: soft}
                                            access:
                                              free: {effects: [{detach: true}]}
                                              grab:
                                                parameters: {to: {type: item}}
                                                effects: [{attach: to}]
                                        """)
                        .build(arena);
        Item a = world.find("a").orElseThrow();
        List<Long> before = digest(world);
        assertThatThrownBy(() -> perform(world, a, "free", Map.of()))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining(
                        "is at the level soft, so it stays attached to the part knot 0");
        assertThatThrownBy(() -> perform(world, a, "grab", Map.of("to", "hand")))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("make a level without parts active first");
        for (String change : List.of("{parent: null}", "{parent: hand}")) {
            assertThatThrownBy(() -> edit(world, change))
                    .isInstanceOf(ActionRefused.class)
                    .hasMessageContaining("stays attached to the part knot 0");
        }
        assertThatThrownBy(() -> edit(world, "{physics: null}"))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("has levels, which describe its physics");
        assertThat(digest(world)).isEqualTo(before);
        change(world, "a", "ball");
        assertThatThrownBy(() -> edit(world, "{physics: null}"))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("set its mass to 0 instead");
        edit(world, "{physics: {mass: 0}}");
        edit(world, "{parent: hand}");
        edit(world, "{parent: null}");
        WorldDescription description = parse(DROP + "items: [{name: hand}]");
        String text = WorldWriter.write(description.of(world, List.of()));
        assertThat(WorldFile.parse("saved", text.getBytes(StandardCharsets.UTF_8)).items())
                .hasSize(2);
    }

    private static void edit(World world, String change) throws Exception {
        WorldEdit.make(
                world,
                3,
                List.of(new EditReader(world.prototype()).change("a", "body", change)),
                Set.of(),
                () -> {});
    }

    /** An item whose name only ends like that of a part does not become a part. */
    @Test
    void aPartThatWasRenamedIsNotFound() throws Exception {
        World world =
                parse(DROP + "items: [{name: a, like: drop, semantic: {level: soft}}]")
                        .build(arena);
        world.rename(world.find("a.knot 0").orElseThrow().id(), "xknot 0");
        for (int i = 1; i < 4; i++) {
            world.add(ItemDefinition.named("xknot " + i).physics("mass", 1).build());
        }
        List<Long> before = digest(world);
        assertThatThrownBy(() -> change(world, "a", "ball"))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("so its parts are not known");
        assertThat(digest(world)).isEqualTo(before);
    }

    @Test
    void aBodyWithTheNameOfARemovedPartIsNoPart() throws Exception {
        World world =
                parse(DROP + "items: [{name: a, like: drop, semantic: {level: soft}}]")
                        .build(arena);
        world.rename(world.find("a").orElseThrow().id(), "b");
        world.removeCascade(world.find("a.knot 3").orElseThrow().id());
        world.add(ItemDefinition.named("a.knot 3").physics("mass", 0.25).build());
        List<Long> before = digest(world);
        assertThatThrownBy(() -> change(world, "b", "ball"))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("the part a.knot 3 of the level soft is missing");
        assertThat(digest(world)).isEqualTo(before);
    }

    /** Agents cannot have such a name, so no agent prevents a change of the level. */
    @Test
    void namesOfPartsAreKnownAtEachLevel() throws Exception {
        World world = parse(DROP + "items: [{name: a.b, like: drop}, {name: c}]").build(arena);
        assertThat(LevelChange.isOfPart(world, "a.b.knot 0")).isTrue();
        for (String other : List.of("a.b.knot 4", "a.b", "b.knot 0", "c.knot 0", "knot 0", ".")) {
            assertThat(LevelChange.isOfPart(world, other)).as(other).isFalse();
        }
    }

    @Test
    void partsThatReferToEachOtherInACircleLeaveTogether() throws Exception {
        World world =
                parse(
                                """
                                properties:
                                  - {name: other, kind: tie, refersTo: tie, doc: Another tie.}
                                items:
                                  - name: a
                                    semantic: {level: soft}
                                    levels:
                                      ball: {physics: {mass: 1}}
                                      soft:
                                        parts:
                                          core: {physics: {mass: 1}}
                                          s: {kind: tie, physics: {other: t}}
                                          t: {kind: tie, physics: {other: s}}
                                """)
                        .build(arena);
        assertThat(world.find("a.s")).isPresent();
        change(world, "a", "ball");
        assertThat(world.items()).extracting(Item::name).containsExactly("world", "a");
        change(world, "a", "soft");
        assertThat(world.find("a.t")).isPresent();
    }

    private FrameLoop loop(World world) {
        var bus = new FrameBus();
        new LevelKeeper().subscribeTo(bus);
        bus.subscribe(FramePhase.PUBLISH, "test", event -> events.addAll(world.events()));
        return new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
    }

    @Test
    void aConditionChoosesTheLevelBeforeTheLawsOfAFrame() throws Exception {
        World world = parse(DROP + "items: [{name: a, like: drop}]").build(arena);
        Item a = world.find("a").orElseThrow();
        a.physics().set("velocity", 0, 0, 5);
        FrameLoop loop = loop(world);
        loop.step();
        assertThat(events).isEmpty();
        a.physics().set("velocity", 0, 0, 5.1);
        loop.step();
        assertThat(a.semantic().get("level")).contains("soft");
        loop.step();
        assertThat(events).hasSize(1);
        assertThat(events.getFirst().frame()).isEqualTo(2);
        for (int i = 0; i < 4; i++) {
            Item knot = world.find("a.knot " + i).orElseThrow();
            knot.physics().set("velocity", 0, i % 2 == 0 ? 1 : -1, 0.5);
        }
        loop.step();
        assertThat(a.semantic().get("level")).as("it vibrates").contains("soft");
        for (int i = 0; i < 4; i++) {
            world.find("a.knot " + i).orElseThrow().physics().set("velocity", 0, 0, 0.5);
        }
        loop.step();
        assertThat(a.semantic().get("level")).contains("ball");
        assertThat(a.physics().vector("velocity"))
                .usingComparatorWithPrecision(1e-14)
                .containsExactly(0, 0, 0.5);
    }

    /** A condition that cannot be met is reported once, and the world continues. */
    @Test
    void aChangeThatIsImpossibleIsReportedOnce() throws Exception {
        World world = parse(DROP + "items: [{name: a, like: drop}]").build(arena);
        world.add(ItemDefinition.named("a.knot 2").build());
        FrameLoop loop = loop(world);
        loop.step();
        loop.step();
        assertThat(events).hasSize(1);
        assertThat(events.getFirst().type()).isEqualTo("fault");
        assertThat(events.getFirst().fields().get("message").toString())
                .contains("the name a.knot 2 of a part of the level soft is taken");
        assertThat(world.find("a").orElseThrow().semantic().get("level")).contains("ball");
    }

    /** Costly conditions do not delay the world. Those of later items wait, which is reported. */
    @Test
    void theConditionsOfAFrameHaveALimitedCost() throws Exception {
        String ten = "[0,1,2,3,4,5,6,7,8,9]";
        String costly = ten + ".all(a, " + ten + ".all(b, [0,1,2,3,4].all(c, a + b + c >= 0)))";
        World world =
                parse(
                                """
                                prefabs:
                                  drop:
                                    levels:
                                      ball: {physics: {mass: 1}}
                                      soft: {physics: {mass: 1}, when: "%s && velocity[0] > 1.0"}
                                items:
                                  - {name: 'a{i}', like: drop, repeat: 100}
                                """
                                        .formatted(costly))
                        .build(arena);
        Item first = world.find("a0").orElseThrow();
        Item last = world.find("a99").orElseThrow();
        first.physics().set("velocity", 2, 0, 0);
        last.physics().set("velocity", 2, 0, 0);
        FrameLoop loop = loop(world);
        loop.step();
        loop.step();
        assertThat(first.semantic().get("level")).contains("soft");
        assertThat(last.semantic().get("level")).contains("ball");
        assertThat(events.stream().filter(event -> event.type().equals("fault")))
                .singleElement()
                .satisfies(
                        fault ->
                                assertThat(fault.fields().get("message").toString())
                                        .contains("need more than 200000 steps in a frame"));
        world.items().stream()
                .filter(item -> item.name().startsWith("a") && !item.name().equals("a99"))
                .limit(95)
                .forEach(item -> world.remove(item.id()));
        loop.step();
        assertThat(last.semantic().get("level")).contains("soft");
    }

    @Test
    void aStoredItemKeepsItsLevelsAndConditions() throws Exception {
        WorldDescription world = parse(DROP + "items: [{name: a, like: drop}]");
        ItemDefinition a = item(world, "a");
        var writer = new ItemWriter(world.prototype());
        ItemDefinition read = WorldFile.parseItem("a", writer.write(a), world.prototype());
        assertThat(writer.write(read)).isEqualTo(writer.write(a));
        assertThat(read.levels().getLast().when().map(LevelCondition::text))
                .contains("norm(velocity) > 5.0");
        assertThat(read.levels().getLast().items()).hasSize(8);
    }
}
