// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;
import static org.assertj.core.api.Assertions.catchThrowableOfType;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Colour;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.World;
import reve.core.world.WorldEvent;
import reve.core.world.WorldPrototype;

import java.util.List;
import java.util.Map;
import java.util.Optional;

class DeclaredActionTest {
    private static final Parameter KICK = Parameter.number("kick", 3, Unit.parse("kN*s"), "");
    private static final Parameter TEXT = Parameter.text("text", "");

    private final OffHeapArena arena = new OffHeapArena();

    @AfterEach
    void free() {
        arena.close();
    }

    private World world(String prototype) {
        World world = new World("test", WorldPrototype.standard(prototype), arena);
        world.add(
                ItemDefinition.named("ball")
                        .physics("mass", 2)
                        .physics("velocity", 1, 0, 0)
                        .build());
        world.add(ItemDefinition.named("wall").physics("mass", 0).build());
        world.add(ItemDefinition.named("box").build());
        return world;
    }

    private static void perform(
            World world,
            String item,
            List<Parameter> parameters,
            Map<String, ?> given,
            Effect... effects)
            throws ActionRefused {
        var action = new DeclaredAction("test", "", parameters, List.of(effects));
        Item target = world.find(item).orElseThrow();
        action.perform(
                new ActionCall(
                        world, 7, target, world.find("wall"), Arguments.check(action, given)));
    }

    private static String refusal(
            World world,
            String item,
            Map<String, ?> given,
            List<Parameter> parameters,
            Effect... effects) {
        return catchThrowableOfType(
                        ActionRefused.class, () -> perform(world, item, parameters, given, effects))
                .code();
    }

    @Test
    void impulseChangesVelocityByImpulseOverMass() throws ActionRefused {
        World world = world("si-f64");

        perform(
                world,
                "ball",
                List.of(KICK),
                Map.of("kick", List.of(0.001, 0, -0.002)),
                new Effect.Impulse(new Operand.Argument(KICK)));

        assertThat(world.find("ball").orElseThrow().physics().vector("velocity"))
                .containsExactly(new double[] {1 + 1 / 2.0, 0, -2 / 2.0}, within(1e-15));
    }

    @Test
    void impulseIsRefusedWhereNothingCanMove() {
        World world = world("si-f64");
        var impulse = new Effect.Impulse(new Operand.Argument(KICK));
        Map<String, ?> given = Map.of("kick", List.of(1, 0, 0));

        assertThat(refusal(world, "wall", given, List.of(KICK), impulse)).isEqualTo("immovable");
        assertThat(refusal(world, "box", given, List.of(KICK), impulse)).isEqualTo("no-physics");
        assertThat(world.find("wall").orElseThrow().physics().vector("velocity"))
                .containsExactly(0, 0, 0);
    }

    @Test
    void propertyIsSetInItsOwnUnit() throws ActionRefused {
        World world = world("si-f64");
        Parameter grams = Parameter.number("m", 1, Unit.parse("g"), "");

        perform(
                world,
                "ball",
                List.of(grams),
                Map.of("m", 500),
                new Effect.SetProperty("mass", new Operand.Argument(grams)),
                new Effect.SetProperty(
                        "charge", new Operand.Numbers(new double[] {3}, Unit.parse("C"))));

        assertThat(world.find("ball").orElseThrow().physics().scalar("mass")).isEqualTo(0.5);
        assertThat(world.find("ball").orElseThrow().physics().scalar("charge")).isEqualTo(3);
    }

    @Test
    void valueThatAColumnCannotHoldIsRefusedBeforeAnythingHappens() {
        World world = world("si-f32");
        Parameter mass = Parameter.number("m", 1, Unit.parse("kg"), "");

        assertThat(
                        refusal(
                                world,
                                "ball",
                                Map.of("m", 1e300),
                                List.of(mass),
                                new Effect.SetSymbol("heavy", new Operand.Symbol(true)),
                                new Effect.SetProperty("mass", new Operand.Argument(mass))))
                .isEqualTo("out-of-range");
        assertThat(
                        refusal(
                                world,
                                "ball",
                                Map.of("m", -1),
                                List.of(mass),
                                new Effect.SetSymbol("heavy", new Operand.Symbol(true)),
                                new Effect.SetProperty("mass", new Operand.Argument(mass))))
                .isEqualTo("out-of-range");
        assertThat(world.find("ball").orElseThrow().semantic().get("heavy")).isEmpty();
        assertThat(world.find("ball").orElseThrow().physics().scalar("mass")).isEqualTo(2);
    }

    @Test
    void colourIsSetOrRefused() throws ActionRefused {
        World world = world("si-f64");
        var paint = new Effect.SetColour(new Operand.Argument(TEXT));

        perform(world, "box", List.of(TEXT), Map.of("text", "#010203"), paint);

        assertThat(world.find("box").orElseThrow().physical().colour())
                .isEqualTo(Colour.parse("#010203"));
        assertThat(refusal(world, "box", Map.of("text", "red"), List.of(TEXT), paint))
                .isEqualTo("not-a-colour");
    }

    @Test
    void symbolTakesConstantsAndArguments() throws ActionRefused {
        World world = world("si-f64");
        Parameter truth = Parameter.truth("on", "");
        Parameter number = Parameter.number("n", 1, Unit.parse("km"), "");

        perform(
                world,
                "box",
                List.of(TEXT, truth, number),
                Map.of("text", "hi", "on", false, "n", 3),
                new Effect.SetSymbol("a", new Operand.Argument(TEXT)),
                new Effect.SetSymbol("b", new Operand.Argument(truth)),
                new Effect.SetSymbol("c", new Operand.Argument(number)),
                new Effect.SetSymbol("d", new Operand.Symbol("const")),
                new Effect.SetSymbol("e", new Operand.Numbers(new double[] {2}, Unit.ONE)));

        assertThat(world.find("box").orElseThrow().semantic().symbols())
                .containsEntry("a", "hi")
                .containsEntry("b", false)
                .containsEntry("c", 3.0)
                .containsEntry("d", "const")
                .containsEntry("e", 2.0);
    }

    @Test
    void symbolThatCannotBeIsRefusedBeforeAnythingHappens() {
        World world = world("si-f64");
        var light = new Effect.SetSymbol("lit", new Operand.Symbol(true));

        assertThat(
                        refusal(
                                world,
                                "box",
                                Map.of(),
                                List.of(),
                                light,
                                new Effect.SetSymbol("note", new Operand.Symbol("x".repeat(5000)))))
                .isEqualTo("not-a-symbol");
        assertThat(
                        refusal(
                                world,
                                "box",
                                Map.of(),
                                List.of(),
                                light,
                                new Effect.SetSymbol("name", new Operand.Symbol("ball"))))
                .isEqualTo("not-a-symbol");
        assertThat(world.find("box").orElseThrow().semantic().get("lit")).isEmpty();
    }

    @Test
    void eventThatCannotBeIsRefusedBeforeAnythingHappens() {
        World world = world("si-f64");

        assertThatThrownBy(
                        () ->
                                perform(
                                        world,
                                        "box",
                                        List.of(),
                                        Map.of(),
                                        new Effect.SetSymbol("lit", new Operand.Symbol(true)),
                                        new Effect.Raise("two\nlines", "test")))
                .isInstanceOf(ActionRefused.class)
                .hasMessageContaining("event type");
        assertThat(world.find("box").orElseThrow().semantic().get("lit")).isEmpty();
        assertThat(world.events()).isEmpty();
    }

    @Test
    void raisedEventNamesFrameItemActionAndActor() throws ActionRefused {
        World world = world("si-f64");

        perform(world, "box", List.of(), Map.of(), new Effect.Raise("squeak", "test"));

        assertThat(world.events())
                .containsExactly(
                        new WorldEvent(
                                7,
                                "squeak",
                                Map.of("item", "box", "action", "test", "actor", "wall")));
    }

    @Test
    void eventWithoutActorNamesNone() throws ActionRefused {
        World world = world("si-f64");
        var action =
                new DeclaredAction("a", "", List.of(), List.of(new Effect.Raise("squeak", "a")));

        action.perform(
                new ActionCall(
                        world,
                        1,
                        world.find("box").orElseThrow(),
                        Optional.empty(),
                        Arguments.check(action, Map.of())));

        assertThat(world.events())
                .containsExactly(new WorldEvent(1, "squeak", Map.of("item", "box", "action", "a")));
    }

    @Test
    void twoEffectsOnOneThingAreRefusedAtDeclaration() {
        var kick = new Effect.Impulse(new Operand.Argument(KICK));
        var stop =
                new Effect.SetProperty(
                        "velocity", new Operand.Numbers(new double[3], Unit.parse("m/s")));
        assertThatThrownBy(() -> new DeclaredAction("a", "", List.of(KICK), List.of(kick, stop)))
                .isInstanceOf(IllegalArgumentException.class)
                .hasMessage("action a has two effects that change physics.velocity");
    }
}
