// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.unit.Unit;
import reve.core.world.Action;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.Mesh;
import reve.core.world.OffHeapArena;
import reve.core.world.PropertyDescriptor;
import reve.core.world.Shape;
import reve.core.world.TestAction;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Optional;
import java.util.Random;

/**
 * Items that are written and read are equal. The seed is printed; -Dreve.test.seed=N repeats it.
 */
class ItemWriterTest {
    private static final int ITEMS = 1000;
    private static final WorldPrototype DOUBLE = WorldPrototype.standard("si-f64");

    private final long seed = Seed.of("items");
    private final Random random = new Random(seed);

    private static ItemDefinition readBack(ItemDefinition item, WorldPrototype prototype)
            throws WorldFileException {
        return WorldFile.parseItem("item", new ItemWriter(prototype).write(item), prototype);
    }

    @Test
    void writesAnItemAsADesignerWould() {
        ItemDefinition duck =
                ItemDefinition.named("duck")
                        .shape(Shape.sphere(0.06))
                        .colour("#ffd500")
                        .at(0, 0.5, 0)
                        .symbol("class", "toy")
                        .symbol("age", 3)
                        .symbol("squeaks", true)
                        .symbol("answer", "true")
                        .physics("mass", 0.08)
                        .physics("charge", 0)
                        .physics("velocity", 0, 0, 1)
                        .build();

        assertThat(new ItemWriter(DOUBLE).write(duck))
                .isEqualTo(
                        """
                        name: duck
                        physical: {shape: sphere, radius: 0.06, colour: '#ffd500', location: [0, 0.5, 0]}
                        semantic: {age: 3, answer: 'true', class: toy, squeaks: true}
                        physics: {mass: 0.08, velocity: [0, 0, 1]}
                        """);
    }

    @Test
    void actionsAreWrittenAsTheyWereDeclared() throws WorldFileException {
        String text =
                """
                name: lamp
                access:
                  press:
                    doc: 'On: or off.'
                    parameters:
                      colour: {type: text}
                      kick: {components: 3, unit: N*s, doc: A push.}
                      lit: {type: truth}
                    effects:
                      - {impulse: $kick}
                      - {set: physics.charge, to: -0.5}
                      - {set: physical.colour, to: $colour}
                      - {symbol: lit, to: $lit}
                      - {symbol: pressed, to: yes}
                      - {raise: pressed}
                  stop:
                    effects:
                      - set: physics.velocity
                        to: [0, 0, 0]
                physics: {mass: 1}
                """;
        ItemDefinition lamp = WorldFile.parseItem("lamp", text, DOUBLE);

        String written = new ItemWriter(DOUBLE).write(lamp);

        assertThat(new ItemWriter(DOUBLE).write(WorldFile.parseItem("again", written, DOUBLE)))
                .isEqualTo(written);
        assertThat(WorldFile.parseItem("again", written, DOUBLE).actions())
                .usingRecursiveComparison()
                .isEqualTo(lamp.actions());
    }

    @Test
    void whatAlikeItemsShareIsWrittenWithoutNumbersAndSymbols() throws WorldFileException {
        try (var arena = new OffHeapArena()) {
            World world = new World("w", DOUBLE, arena);
            Item ball =
                    world.add(
                            WorldFile.parseItem(
                                    "ball",
                                    """
                                    name: ball
                                    physical: {shape: sphere, radius: 2, location: [1, 2, 3]}
                                    semantic: {class: toy}
                                    access: {push: {effects: [{impulse: [1, 0, 0]}]}}
                                    physics: {mass: 1}
                                    """,
                                    DOUBLE));

            String written =
                    new ItemWriter(DOUBLE).write(world.symbols().get(ball.id()).likeness());

            ItemDefinition read = WorldFile.parseItem("ball", written, DOUBLE);
            assertThat(read.shape()).isEqualTo(Shape.sphere(2));
            assertThat(read.symbols()).isEmpty();
            assertThat(read.actions())
                    .usingRecursiveComparison()
                    .isEqualTo(ball.definition().actions());
            assertThat(read.hasPhysics()).isFalse();
            assertThat(read.location()).containsExactly(0, 0, 0);
        }
    }

    @Test
    void anActionWrittenInJavaIsRefusedByName() {
        Action dance = new TestAction("dance", "");
        ItemDefinition item = ItemDefinition.named("robot").action(dance).build();

        assertThatIllegalArgumentException()
                .isThrownBy(() -> new ItemWriter(DOUBLE).write(item))
                .withMessageStartingWith(
                        "item robot: action dance is a reve.core.world.TestAction");
    }

    @Test
    void randomItemsAreReadBackToTheBit() throws WorldFileException {
        for (int n = 0; n < ITEMS; n++) {
            WorldPrototype prototype =
                    WorldPrototype.standard(random.nextBoolean() ? "si-f64" : "si-f32");
            ItemDefinition item = RandomItems.body(random, prototype, "item " + n);
            try (var arena = new OffHeapArena()) {
                World world = new World("w", prototype, arena);
                ItemDefinition before = world.add(item).definition();
                ItemDefinition after = readBack(before, prototype);
                ItemDefinition again = new World("again", prototype, arena).add(after).definition();
                requireSame(again, before);
            }
        }
    }

    private void requireSame(ItemDefinition item, ItemDefinition expected) {
        String what = "seed " + seed + ", " + expected.name();
        assertThat(item.name()).as(what).isEqualTo(expected.name());
        assertThat(item.kind()).as(what).isEqualTo(expected.kind());
        if (expected.shape() instanceof Mesh mesh) {
            Mesh read = (Mesh) item.shape();
            assertThat(read.vertices()).as(what).isEqualTo(mesh.vertices());
            assertThat(read.triangles()).as(what).isEqualTo(mesh.triangles());
        } else {
            assertThat(item.shape()).as(what).isEqualTo(expected.shape());
        }
        assertThat(item.colour()).as(what).isEqualTo(expected.colour());
        assertThat(RandomItems.bits(expected.location(), item.location())).as(what).isTrue();
        assertThat(RandomItems.bits(expected.orientation(), item.orientation())).as(what).isTrue();
        assertThat(item.symbols()).as(what).isEqualTo(expected.symbols());
        assertThat(item.sensors()).as(what).isEqualTo(expected.sensors());
        assertThat(item.voice()).as(what).isEqualTo(expected.voice());
        assertThat(item.physicsProperties())
                .as(what)
                .containsExactlyInAnyOrderElementsOf(expected.physicsProperties());
        for (String property : expected.physicsProperties()) {
            assertThat(
                            RandomItems.bits(
                                    expected.physics(property).orElseThrow(),
                                    item.physics(property).orElseThrow()))
                    .as(what + ": " + property)
                    .isTrue();
        }
        assertThat(item.references()).as(what).isEqualTo(expected.references());
    }

    @Test
    void aPropertyOfOnesOwnIsWrittenInItsUnit() throws WorldFileException {
        WorldPrototype extended =
                DOUBLE.extendedBy(
                        List.of(
                                new PropertyDescriptor(
                                        "heat",
                                        "body",
                                        DOUBLE.realType(),
                                        1,
                                        Unit.parse("km/h"),
                                        Optional.empty(),
                                        "")));
        ItemDefinition item =
                WorldFile.parseItem("i", "{name: a, physics: {heat: 10 m/s}}", extended);

        assertThat(item.physics("heat").orElseThrow()).containsExactly(36);
        assertThat(new ItemWriter(extended).write(item)).contains("heat: 36}");
    }
}
