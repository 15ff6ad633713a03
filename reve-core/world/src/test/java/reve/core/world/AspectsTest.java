// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.unit.Unit;

import java.util.List;
import java.util.Map;
import java.util.Optional;

class AspectsTest {

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());

    @ParameterizedTest
    @ValueSource(strings = {"si-f64", "si-f32"})
    void whatIsWrittenIsReadBack(String prototype) {
        World any = new World("any", WorldPrototype.standard(prototype), new OffHeapArena());
        Item ball =
                any.add(
                        ItemDefinition.named("ball")
                                .shape(Shape.sphere(0.5))
                                .colour("#c0392b")
                                .at(1, -2, 3.5)
                                .physics("mass", 1000)
                                .physics("velocity", 0, 3, 0)
                                .build());
        assertThat(ball.physical().location()).containsExactly(1, -2, 3.5);
        assertThat(ball.physical().orientation()).containsExactly(0, 0, 0, 1);
        assertThat(ball.physical().size()).containsExactly(1, 1, 1);
        assertThat(ball.physical().shape()).isEqualTo(Shape.sphere(0.5));
        assertThat(ball.physical().colour()).hasToString("#c0392bff");
        assertThat(ball.physics().scalar("mass")).isEqualTo(1000);
        assertThat(ball.physics().vector("velocity")).containsExactly(0, 3, 0);

        ball.physical().setLocation(4, 5, 6);
        ball.physical().setOrientation(0, 2, 0, 0);
        ball.physical().setColour(Colour.parse("#00ff00"));
        ball.physical().setShape(Shape.box(1, 2, 4));
        ball.physics().set("velocity", 7, 8, 9);
        assertThat(ball.physical().location()).containsExactly(4, 5, 6);
        assertThat(ball.physical().orientation()).containsExactly(0, 1, 0, 0);
        assertThat(ball.physical().colour()).hasToString("#00ff00ff");
        assertThat(ball.physical().size()).containsExactly(1, 2, 4);
        assertThat(any.table("body").column("shape").getInt(0, 0)).isEqualTo(Shape.BOX);
        assertThat(ball.semantic().get("dimensions")).contains(List.of(1.0, 2.0, 4.0));
        assertThat(ball.physics().vector("velocity")).containsExactly(7, 8, 9);
    }

    @Test
    void f32RoundsButRefusesWhatItCannotHold() {
        World narrow = new World("n", WorldPrototype.standard("si-f32"), new OffHeapArena());
        Item ball = narrow.add(ItemDefinition.named("ball").physics("mass", 0.1).build());
        assertThat(ball.physics().scalar("mass")).isEqualTo(0.1f).isNotEqualTo(0.1);
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("mass", 1e39))
                .withMessage("item ball: mass is 1.0E39, which does not fit type F32");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physical().setLocation(0, 0, 1e39));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> narrow.add(ItemDefinition.named("far").at(1e39, 0, 0).build()));
    }

    @ParameterizedTest
    @ValueSource(doubles = {Double.NaN, Double.POSITIVE_INFINITY, Double.NEGATIVE_INFINITY})
    void refusesWhatIsNotFiniteAndKeepsTheOldValue(double bad) {
        Item ball =
                world.add(
                        ItemDefinition.named("ball")
                                .at(1, 2, 3)
                                .physics("mass", 5)
                                .physics("velocity", 1, 1, 1)
                                .build());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("mass", bad))
                .withMessage("item ball: mass is " + bad + ", expected finite numbers");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("velocity", 9, bad, 9));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physical().setLocation(9, 9, bad));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physical().setOrientation(bad, 0, 0, 1));
        assertThatIllegalArgumentException().isThrownBy(() -> ball.semantic().set("heat", bad));
        assertThat(ball.physics().scalar("mass")).isEqualTo(5);
        assertThat(ball.physics().vector("velocity")).containsExactly(1, 1, 1);
        assertThat(ball.physical().location()).containsExactly(1, 2, 3);
        assertThat(ball.physical().orientation()).containsExactly(0, 0, 0, 1);
        assertThat(ball.semantic().get("heat")).isEmpty();
    }

    @ParameterizedTest
    @ValueSource(strings = {"mass", "radius"})
    void refusesWhatIsBelowTheLeastValueAndKeepsTheOldOne(String property) {
        Item ball = world.add(ItemDefinition.named("ball").physics(property, 5).build());
        String unit = property.equals("mass") ? "kg" : "m";
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set(property, -2))
                .withMessage(
                        "item ball: " + property + " is -2.0, expected 0 or more [" + unit + "]");
        assertThat(ball.physics().scalar(property)).isEqualTo(5);
        ball.physics().set(property, -0.0);
        ball.physics().set("charge", -2);
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                world.add(
                                        ItemDefinition.named("hole")
                                                .physics(property, -1e-300)
                                                .build()))
                .withMessageStartingWith("item hole: " + property + " is -1.0E-300");
        assertThat(world.find("hole")).isEmpty();
    }

    @Test
    void refusesUnknownPropertiesAndWrongNumbersOfComponents() {
        Item ball = world.add(ItemDefinition.named("ball").physics("mass", 1).build());
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("masss", 1))
                .withMessageContaining("masss")
                .withMessageContaining("mass, charge");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("position", 1, 2, 3))
                .withMessageContaining("no physics property position");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().set("velocity", 1, 2))
                .withMessageContaining("2 components, expected 3 [m/s]");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> ball.physics().scalar("velocity"))
                .withMessageContaining("3 components");
    }

    @Test
    void integersMustBeWholeAndInRange() {
        WorldPrototype counted =
                WorldPrototype.standard("si-f64")
                        .extendedBy(
                                List.of(
                                        new PropertyDescriptor(
                                                "layer",
                                                "body",
                                                ScalarType.I32,
                                                1,
                                                Unit.parse("1"),
                                                Optional.empty(),
                                                ""),
                                        new PropertyDescriptor(
                                                "mask",
                                                "body",
                                                ScalarType.U32,
                                                1,
                                                Unit.parse("1"),
                                                Optional.empty(),
                                                "")));
        World any = new World("any", counted, new OffHeapArena());
        PhysicsAspect ball =
                any.add(
                                ItemDefinition.named("ball")
                                        .physics("layer", -7)
                                        .physics("mask", 4294967295.0)
                                        .build())
                        .physics();
        assertThat(ball.scalar("layer")).isEqualTo(-7);
        assertThat(ball.scalar("mask")).isEqualTo(4294967295.0);
        assertThatIllegalArgumentException().isThrownBy(() -> ball.set("layer", 0.5));
        assertThatIllegalArgumentException().isThrownBy(() -> ball.set("layer", 2147483648.0));
        assertThatIllegalArgumentException().isThrownBy(() -> ball.set("mask", -1));
        assertThatIllegalArgumentException().isThrownBy(() -> ball.set("mask", 4294967296.0));
    }

    @Test
    void sceneryHasNoPhysicsUntilItGetsAFirstProperty() {
        Item lamp = world.add(ItemDefinition.named("lamp").at(1, 2, 3).build());
        Item ball = world.add(ItemDefinition.named("ball").at(4, 5, 6).physics("mass", 2).build());
        Table body = world.table("body");
        assertThat(lamp.physics().isEmpty()).isTrue();
        assertThat(lamp.physics().properties()).isEmpty();
        assertThatIllegalStateException()
                .isThrownBy(() -> lamp.physics().scalar("mass"))
                .withMessageContaining("lamp")
                .withMessageContaining("scenery");
        assertThat(body.physicsRowCount()).isEqualTo(1);
        assertThat(body.rowOf(ball.id())).isZero();

        long layout = world.layoutVersion();
        lamp.physics().set("mass", 3);
        assertThat(world.layoutVersion()).isGreaterThan(layout);
        assertThat(lamp.physics().isEmpty()).isFalse();
        assertThat(lamp.physics().properties()).contains("mass", "velocity");
        assertThat(body.physicsRowCount()).isEqualTo(2);
        assertThat(lamp.physics().scalar("mass")).isEqualTo(3);
        assertThat(lamp.physical().location()).containsExactly(1, 2, 3);
        assertThat(ball.physical().location()).containsExactly(4, 5, 6);
        assertThat(ball.physics().scalar("mass")).isEqualTo(2);
    }

    @Test
    void anItemWithPhysicsHasAllPropertiesOfItsKindAtZero() {
        Item ball = world.add(ItemDefinition.named("ball").physics("charge", 1).build());
        assertThat(ball.physics().scalar("mass")).isZero();
        assertThat(ball.physics().vector("appliedForce")).containsExactly(0, 0, 0);
    }

    @Test
    void aRowIsReusedWithoutOldValues() {
        Item old = world.add(ItemDefinition.named("old").at(1, 1, 1).physics("charge", 9).build());
        world.remove(old.id());
        Item young = world.add(ItemDefinition.named("young").physics("mass", 1).build());
        assertThat(young.physics().scalar("charge")).isZero();
        assertThat(young.physical().location()).containsExactly(0, 0, 0);
    }

    @Test
    void standardSymbolsAreAlwaysThere() {
        Item ball =
                world.add(
                        ItemDefinition.named("ball")
                                .shape(Shape.plane(4, 6))
                                .symbol("zeal", true)
                                .symbol("age", 3)
                                .build());
        assertThat(ball.semantic().symbols())
                .containsExactly(
                        Map.entry("name", "ball"),
                        Map.entry("class", "body"),
                        Map.entry("dimensions", List.of(4.0, 0.0, 6.0)),
                        Map.entry("age", 3.0),
                        Map.entry("zeal", true));
        ball.semantic().set("class", "floor");
        assertThat(ball.semantic().get("class")).contains("floor");
        assertThat(ball.semantic().symbols().get("class")).isEqualTo("floor");
        ball.semantic().remove("class");
        assertThat(ball.semantic().get("class")).contains("body");
        assertThatIllegalArgumentException().isThrownBy(() -> ball.semantic().set("name", "other"));
    }

    @Test
    void changingASymbolMakesANewVersionAndLeavesTheOldOneAlone() {
        Item ball = world.add(ItemDefinition.named("ball").symbol("lit", false).build());
        var before = world.symbols();
        ball.semantic().set("lit", true);
        assertThat(before.get(ball.id()).get("lit")).contains(false);
        assertThat(world.symbols().get(ball.id()).get("lit")).contains(true);
    }

    @Test
    void onlyBodiesHaveAPlace() {
        world.add(ItemDefinition.named("a").physics("mass", 1).build());
        world.add(ItemDefinition.named("b").physics("mass", 1).build());
        Item spring =
                world.add(
                        ItemDefinition.named("s")
                                .kind("spring")
                                .reference("end1", "a")
                                .reference("end2", "b")
                                .build());
        assertThat(spring.physical().isEmpty()).isTrue();
        assertThatIllegalStateException()
                .isThrownBy(() -> spring.physical().location())
                .withMessageContaining("no place");
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () ->
                                world.add(
                                        ItemDefinition.named("t")
                                                .kind("spring")
                                                .at(1, 2, 3)
                                                .build()));
    }

    @Test
    void editsRaiseTheVersionOfTheirColumnOnly() {
        Item ball = world.add(ItemDefinition.named("ball").physics("mass", 1).build());
        Column mass = world.table("body").column("mass");
        Column velocity = world.table("body").column("velocity");
        long massBefore = mass.version();
        long velocityBefore = velocity.version();
        ball.physics().set("mass", 2);
        assertThat(mass.version()).isGreaterThan(massBefore);
        assertThat(velocity.version()).isEqualTo(velocityBefore);
        mass.touch();
        assertThat(mass.version()).isGreaterThan(massBefore + 1);
    }

    @Test
    void columnsAreReadableAsSegmentsAndBuffersOfExactlyTheUsedRows() {
        for (int i = 0; i < 3; i++) {
            world.add(ItemDefinition.named("ball" + i).physics("velocity", i, 10 + i, 0.5).build());
        }
        Column velocity = world.table("body").column("velocity");
        assertThat(velocity.segment().byteSize()).isEqualTo(3 * 3 * 8);
        assertThat(velocity.segment().address() % 4096).isZero();
        assertThat(velocity.buffer().isDirect()).isTrue();
        assertThat(velocity.buffer().asDoubleBuffer().get(7)).isEqualTo(12);
        assertThat(velocity.getDouble(2, 1)).isCloseTo(12, within(0.0));
    }

    @Test
    void aRemovedItemRefusesEveryUse() {
        Item ball = world.add(ItemDefinition.named("ball").physics("mass", 1).build());
        world.remove(ball.id());
        for (Runnable use :
                List.<Runnable>of(
                        () -> ball.physics().scalar("mass"),
                        () -> ball.physics().set("mass", 1),
                        () -> ball.physical().location(),
                        () -> ball.semantic().symbols(),
                        () -> ball.semantic().set("a", "b"),
                        () -> ball.access().actions())) {
            assertThatIllegalStateException()
                    .isThrownBy(use::run)
                    .withMessageContaining("item ball")
                    .withMessageContaining("removed");
        }
    }

    @Test
    void symbolHasTheTypeThatIsDeclaredForIt() {
        WorldPrototype declared =
                WorldPrototype.standard("si-f64")
                        .withSymbols(
                                List.of(
                                        new SymbolDescriptor("tags", SymbolType.LIST, Unit.ONE, ""),
                                        new SymbolDescriptor(
                                                "limit",
                                                SymbolType.NUMBER,
                                                Unit.parse("km/h"),
                                                "")));
        World world = new World("declared", declared, new OffHeapArena());
        Item sign = world.add(ItemDefinition.named("sign").symbol("limit", 30).build());

        sign.semantic().set("tags", List.of("round", 2));
        assertThat(sign.semantic().get("tags")).contains(List.of("round", 2.0));
        assertThatIllegalArgumentException()
                .isThrownBy(() -> sign.semantic().set("limit", "fast"))
                .withMessage("item sign: limit is a text, declared as a number");
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () -> world.add(ItemDefinition.named("other").symbol("tags", 3).build()))
                .withMessage("item other: tags is a number, declared as a list");
        assertThat(world.find("other")).isEmpty();
    }

    @Test
    void symbolIsDeclaredOnce() {
        var tags = new SymbolDescriptor("tags", SymbolType.LIST, Unit.ONE, "");
        assertThatIllegalArgumentException()
                .isThrownBy(
                        () -> WorldPrototype.standard("si-f64").withSymbols(List.of(tags, tags)))
                .withMessageContaining("tags is declared twice");
    }
}
