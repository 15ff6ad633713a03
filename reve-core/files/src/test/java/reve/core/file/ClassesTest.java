// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.image.PrototypeCodec;
import reve.core.image.Trees;
import reve.core.image.WorldImageCodec;
import reve.core.mesh.Assets;
import reve.core.mesh.WorldFolder;
import reve.core.rule.Rules;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.SymbolBytes;
import reve.core.world.World;
import reve.core.world.WorldImage;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Set;

/** Classes of items in world files: inherited symbols, initial values, rules, saved worlds. */
class ClassesTest {
    private static final String HEAD = "reve: 1\nname: w\n";
    private static final String CLASSES =
            HEAD
                    + """
                    properties: [{name: volume, kind: body, unit: l, min: 0}]
                    classes:
                      container: {doc: Holds other things.}
                      vessel: {is: container, semantic: {holds: liquid, depth: 20 cm}, physics: {volume: 0.5}}
                      cup: {is: vessel, semantic: {fragile: true}, physics: {density: 2500 kg/m^3}}
                      band: {is: spring, physics: {springConstant: 3 kN/m}}
                      basket: container
                      c0: {physics: {mass: 3}}
                      c1: {is: c0, physics: {mass: 4}}
                    symbols: {depth: {type: number, unit: mm}}
                    """;
    private static final double MASS_OF_CUP = 2500 * 4 / 3.0 * Math.PI * 0.001;

    private final OffHeapArena arena = new OffHeapArena();

    @AfterEach
    void close() {
        arena.close();
    }

    private static WorldDescription parse(String text) throws WorldFileException {
        return WorldFile.parse("w", text.getBytes(StandardCharsets.UTF_8));
    }

    private World world(String items) throws WorldFileException {
        return parse(CLASSES + items).build(arena);
    }

    /** Each client that perceives an item receives the symbols of its class. */
    @Test
    void inheritedSymbolsCountTowardsTheLimitOfSymbols() throws Exception {
        World world = world("items: [{name: mug}, {name: stone}]\n");
        long none = world.symbolBytes();
        long growth = SymbolBytes.growth(item(world, "mug"), "class", "cup");
        assertThat(growth)
                .isGreaterThan("cup holds depth fragile liquid vessel container".length());
        item(world, "mug").semantic().set("class", "cup");
        assertThat(world.symbolBytes()).isEqualTo(none + growth);
        assertThat(SymbolBytes.growth(item(world, "stone"), "class", "cup")).isEqualTo(growth);
        assertThat(
                        SymbolBytes.of(
                                world, ItemDefinition.named("new").symbol("class", "cup").build()))
                .isEqualTo(growth);
        item(world, "mug").semantic().set("class", "basket");
        assertThat(world.symbolBytes()).isBetween(none + 1, none + growth - 1);
        world.remove(item(world, "mug").id());
        assertThat(world.symbolBytes()).isEqualTo(none);
    }

    private static Item item(World world, String name) {
        return world.find(name).orElseThrow();
    }

    private static double mass(World world, String item) {
        return item(world, item).physics().scalar("mass");
    }

    @Test
    void itemsInheritSymbolsInTheDeclaredUnit() throws Exception {
        World world = world("items: [{name: mug, semantic: {class: cup}}]\n");
        assertThat(item(world, "mug").semantic().symbols())
                .containsEntry("classes", List.of("cup", "vessel", "container", "body"))
                .containsEntry("holds", "liquid")
                .containsEntry("depth", 200.0)
                .containsEntry("fragile", true);
        assertThat(item(world, "mug").physics().isEmpty()).isTrue();
    }

    @Test
    void itemsWithPhysicsHaveTheInitialValuesOfTheirClass() throws Exception {
        World world =
                world(
                        """
                        prefabs:
                          any: {physical: {shape: sphere, radius: 10 cm}, semantic: {class: cup}, physics: {charge: 1}}
                          bare: {physical: {shape: sphere, radius: 10 cm}, semantic: {class: cup}, physics: {}}
                        items:
                          - {name: whole, like: bare}
                          - {name: charged, like: any}
                          - {name: charged too, like: any}
                          - {name: other, like: any, semantic: {class: basket}}
                          - {name: heavy, like: any, physics: {mass: 9 kg, volume: 2}}
                          - {name: light, like: any, physics: {density: 10}}
                          - {name: lid, like: any, parent: whole}
                          - {name: "row {i}", like: any, repeat: 3, physical: {location: "{[i, 0, 0]}"}}
                          - {name: "mix {i}", like: bare, repeat: {i: 2}, semantic: {class: "c{i}"}}
                          - {name: set, parts: {one: {like: any}}}
                          - {name: rubber, kind: spring, semantic: {class: band}, physics: {end1: heavy, end2: light}}
                        """);
        for (String cup : List.of("whole", "charged", "charged too", "row 0", "row 2", "set.one")) {
            assertThat(mass(world, cup)).as(cup).isCloseTo(MASS_OF_CUP, within(1e-12));
            assertThat(item(world, cup).physics().scalar("volume")).as(cup).isEqualTo(0.5);
        }
        assertThat(item(world, "whole").physics().vector("inertia")[0])
                .isCloseTo(0.4 * MASS_OF_CUP * 0.01, within(1e-14));
        assertThat(mass(world, "mix 0")).isEqualTo(3);
        assertThat(mass(world, "mix 1")).isEqualTo(4);
        assertThat(mass(world, "other")).isZero();
        assertThat(mass(world, "heavy")).isEqualTo(9);
        assertThat(item(world, "heavy").physics().vector("inertia")).containsExactly(0, 0, 0);
        assertThat(item(world, "heavy").physics().scalar("volume")).isEqualTo(2);
        assertThat(mass(world, "light")).isCloseTo(MASS_OF_CUP / 250, within(1e-12));
        assertThat(mass(world, "lid")).isZero();
        assertThat(item(world, "lid").physics().scalar("volume")).isEqualTo(0.5);
        assertThat(item(world, "rubber").physics().scalar("springConstant")).isEqualTo(3000);
    }

    @Test
    void theMassFollowsFromTheSubstanceOfAClass() throws Exception {
        World world =
                parse(
                                HEAD
                                        + """
                                        classes:
                                          vessel: {physics: {substance: glass, friction: 0.7}}
                                          jug: {is: vessel, physics: {substance: ore}}
                                        substances: {ore: {density: 5000}}
                                        items:
                                          - {name: a, physical: {shape: box, size: [1, 1, 1]}, semantic: {class: vessel}, physics: {}}
                                          - {name: b, physical: {shape: box, size: [1, 1, 1]}, semantic: {class: jug}, physics: {}}
                                          - {name: c, physical: {shape: box, size: [1, 1, 1]}, semantic: {class: jug}, physics: {substance: ice}}
                                          - {name: d, physical: {shape: box, size: [1, 1, 1]}, semantic: {class: jug}, physics: {mass: 3}}
                                          - {name: e, physical: {shape: plane, size: [1, 1]}, semantic: {class: jug}, physics: {}}
                                        """)
                        .build(arena);
        assertThat(mass(world, "a")).isEqualTo(2600);
        assertThat(mass(world, "e")).as("of a plane").isZero();
        assertThat(mass(world, "b")).isEqualTo(5000);
        assertThat(mass(world, "c")).isBetween(900.0, 930.0);
        assertThat(mass(world, "d")).isEqualTo(3);
        double ore = item(world, "b").physics().scalar("substance");
        assertThat(item(world, "d").physics().scalar("substance")).isEqualTo(ore);
        assertThat(item(world, "e").physics().scalar("substance")).isEqualTo(ore);
        assertThat(item(world, "a").physics().scalar("substance")).isNotEqualTo(ore).isPositive();
        assertThat(item(world, "b").physics().scalar("friction")).isEqualTo(0.7);
        // the rows of the substances that only classes name
        assertThat(world.table("substancePair").rowCount()).isGreaterThanOrEqualTo(3);
    }

    @Test
    void rulesForAClassApplyToTheClassesBelowIt() throws Exception {
        WorldDescription description =
                parse(
                        CLASSES
                                + """
                                rules:
                                  full: {is: "semantic.depth > 0.1", class: vessel}
                                  breaks: "'container' in semantic.classes && 'fragile' in semantic"
                                items:
                                  - {name: mug, semantic: {class: cup}}
                                  - {name: pot, semantic: {class: vessel, depth: 5 cm}}
                                  - {name: hamper, semantic: {class: basket}}
                                  - {name: stone}
                                """);
        World world = description.build(arena);
        var rules = new Rules(world, description.rules(), description.ruleSteps());
        rules.update(0);
        assertThat(item(world, "mug").semantic().get("full")).contains(true);
        assertThat(item(world, "pot").semantic().get("full")).contains(false);
        assertThat(item(world, "hamper").semantic().get("full")).isEmpty();
        assertThat(item(world, "mug").semantic().get("breaks")).contains(true);
        assertThat(item(world, "pot").semantic().get("breaks")).contains(false);
        assertThat(item(world, "stone").semantic().get("breaks")).contains(false);
        assertThat(world.events()).isEmpty();

        item(world, "hamper").semantic().set("class", "cup");
        item(world, "mug").semantic().set("class", "basket");
        rules.update(1);
        assertThat(item(world, "hamper").semantic().get("full")).contains(true);
        assertThat(item(world, "mug").semantic().get("full")).isEmpty();
        assertThat(item(world, "mug").semantic().get("breaks")).contains(false);
    }

    @Test
    void actionsReadClassesAndCreateItemsOfThem() throws Exception {
        World world =
                world(
                        """
                        items:
                          - name: shelf
                            access:
                              put:
                                parameters: {what: {type: item}}
                                when: "'vessel' in what.semantic.classes"
                                effects:
                                  - {symbol: has, to: $what.name}
                                  - {create: {name: new, physical: {shape: sphere, radius: 10 cm}, semantic: {class: cup}, physics: {}}}
                          - {name: mug, physical: {shape: sphere, radius: 1 cm}, semantic: {class: cup}}
                          - {name: hamper, physical: {shape: sphere, radius: 1 cm}, semantic: {class: basket}}
                        """);
        Item shelf = item(world, "shelf");
        var put = shelf.access().find("put").orElseThrow();
        assertThat(
                        catchThrowableOfType(
                                        ActionRefused.class,
                                        () ->
                                                new ActionCall(
                                                                world,
                                                                1,
                                                                shelf,
                                                                world.find("mug"),
                                                                Arguments.check(
                                                                        put,
                                                                        Map.of("what", "hamper")))
                                                        .perform(put))
                                .code())
                .isEqualTo("condition-failed");
        new ActionCall(
                        world,
                        1,
                        shelf,
                        world.find("mug"),
                        Arguments.check(put, Map.of("what", "mug")))
                .perform(put);
        assertThat(shelf.semantic().get("has")).contains("mug");
        Item made =
                world.withSymbol("classes", "cup").stream()
                        .filter(each -> each.name().startsWith("new"))
                        .findFirst()
                        .orElseThrow();
        assertThat(mass(world, made.name())).isCloseTo(MASS_OF_CUP, within(1e-12));
    }

    @Test
    void editsAddItemsOfClasses() throws Exception {
        World world = world("items: [{name: stone}]\n");
        WorldEdit add =
                new EditReader(world.prototype())
                        .add(
                                "{items: [{name: mug, physical: {shape: sphere, radius: 0.1},"
                                        + " semantic: {class: cup}, physics: {}}]}",
                                new EditReader.Room());
        WorldEdit.make(world, 1, List.of(add), Set.of(), () -> {});
        assertThat(mass(world, "mug")).isCloseTo(MASS_OF_CUP, within(1e-12));
        assertThat(item(world, "mug").semantic().get("fragile")).contains(true);
    }

    @Test
    void aSavedWorldIsReadBackToTheBit() throws Exception {
        WorldDescription read =
                parse(
                        CLASSES
                                + """
                                items:
                                  - {name: mug, physical: {shape: sphere, radius: 0.1}, semantic: {class: cup}, physics: {}}
                                  - {name: ghost, physical: {shape: sphere, radius: 0.1}, semantic: {class: cup}, physics: {charge: 1}}
                                  - {name: sign, physical: {shape: sphere, radius: 0.1}, semantic: {class: cup}}
                                """);
        World world = read.build(arena);
        item(world, "ghost").physics().set("mass", 0);
        item(world, "ghost").physics().set("inertia", 0, 0, 0);
        item(world, "ghost").physics().set("volume", 0);
        WorldDescription now = read.of(world, List.of());
        String text = WorldWriter.write(now);
        WorldDescription again = parse(text);
        assertThat(WorldWriter.write(again)).isEqualTo(text);
        assertThat(again.prototype().classes()).isEqualTo(read.prototype().classes());
        try (var other = new OffHeapArena()) {
            World second = again.build(other);
            assertThat(mass(second, "ghost")).isZero();
            assertThat(item(second, "ghost").physics().scalar("volume")).isZero();
            assertThat(mass(second, "mug")).isEqualTo(mass(world, "mug"));
            assertThat(item(second, "sign").physics().isEmpty()).isTrue();
            assertThat(item(second, "sign").semantic().get("holds")).contains("liquid");
        }
    }

    @Test
    void journalsContainTheHierarchyAndImagesInherit() throws Exception {
        WorldDescription read =
                parse(CLASSES + "items: [{name: mug, semantic: {class: cup, note: x}}]\n");
        byte[] header = Trees.write(PrototypeCodec.write(read.prototype()));
        var prototype = PrototypeCodec.read(Trees.read(header));
        assertThat(prototype.classes()).isEqualTo(read.prototype().classes());
        assertThat(prototype.classes().isEmpty()).isFalse();

        World world = read.build(arena);
        var assets = new Assets(WorldFolder.none());
        try (var image = new WorldImage(world);
                var decoded = new WorldImage(world)) {
            image.copyFrom(world, 0);
            new WorldImageCodec(prototype, assets)
                    .read(new WorldImageCodec(prototype, assets).write(image), decoded);
            assertThat(decoded.symbols()).isEqualTo(image.symbols());
            item(world, "mug").semantic().set("class", "basket");
            world.restore(decoded);
            assertThat(item(world, "mug").semantic().get("fragile")).contains(true);
        }
    }

    @Test
    void aWorldWithoutClassesHasTheSameHeaderAndText() throws Exception {
        WorldDescription world = parse(HEAD + "items: [{name: mug, semantic: {class: cup}}]\n");
        assertThat(PrototypeCodec.write(world.prototype()))
                .containsOnlyKeys("name", "added", "symbols");
        assertThat(WorldWriter.write(world)).doesNotContain("classes");
    }

    @Test
    void otherClassesAndKindsAreReported() throws Exception {
        WorldDescription world =
                parse(
                        CLASSES
                                + """
                                rules: {hot: {is: "true", class: vesel}}
                                items:
                                  - {name: mug, semantic: {class: cupp}}
                                  - {name: bowl, semantic: {class: cupp}}
                                  - {name: stone, semantic: {class: body}}
                                """);
        assertThat(world.warnings())
                .extracting(Problem::toString)
                .containsExactlyInAnyOrder(
                        "w:13:34: warning: class: `vesel` is not one of the classes that the world"
                                + " declares; did you mean `vessel`?",
                        "w:15:35: warning: class: `cupp` is not one of the classes that the world"
                                + " declares; did you mean `cup`?");

        assertThat(
                        problems(
                                CLASSES
                                        + "items: [{name: s, kind: surface, semantic: {class: cup}}]\n"))
                .contains("w:13:52: class: a cup is a body, the item is a surface");
        assertThat(problems(CLASSES + "items: [{name: s, semantic: {class: cup, classes: [a]}}]\n"))
                .singleElement()
                .asString()
                .contains("classes is a symbol that the world derives");
        assertThat(problems(CLASSES + "rules: {classes: \"true\"}\n"))
                .containsExactly("w:13:9: symbol classes is a standard one; a rule cannot give it");
        assertThat(problems(HEAD + "symbols: {classes: {type: list}}\nclasses: {a: {}}\n"))
                .singleElement()
                .asString()
                .startsWith("w:4:11: a world with classes derives the symbol `classes`");
    }

    private static List<String> problems(String text) {
        List<String> found = new ArrayList<>();
        WorldFileException refused =
                catchThrowableOfType(WorldFileException.class, () -> parse(text));
        assertThat(refused).as(text).isNotNull();
        refused.problems().forEach(problem -> found.add(problem.toString()));
        return found;
    }

    @Test
    void longChainsAreRefused() {
        StringBuilder text = new StringBuilder(HEAD + "classes:\n  c0: body\n");
        for (int i = 1; i < 40; i++) {
            text.append("  c").append(i).append(": c").append(i - 1).append('\n');
        }
        assertThat(problems(text.toString()))
                .first()
                .asString()
                .isEqualTo(
                        "w:36:8: c32: more than 32 classes of which each is above the one before");
    }

    @Test
    void aClassOfJointsIsKnownWithoutAJoint() throws Exception {
        assertThat(
                        parse(HEAD + "classes: {hinge: joint, gearbox: {is: gear}}\n")
                                .prototype()
                                .kinds())
                .contains("joint", "gear");
    }
}
