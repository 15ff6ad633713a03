// SPDX-License-Identifier: Apache-2.0
package reve.core.access;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Tag;
import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.file.ItemWriter;
import reve.core.unit.Unit;
import reve.core.world.ActionCall;
import reve.core.world.ActionRefused;
import reve.core.world.Arguments;
import reve.core.world.Colour;
import reve.core.world.Force;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;

/**
 * An action takes effect completely or not at all. The test compares random actions with a model,
 * which applies the effects one by one through the world's methods and starts again when a method
 * throws.
 */
@Tag("slow")
class ChangesModelTest {
    private static final WorldPrototype PROTOTYPE = WorldPrototype.standard("si-f64");
    private static final ItemWriter WRITER = new ItemWriter(PROTOTYPE);
    private static final List<Subject> SUBJECTS =
            List.of(Subject.ITEM, Subject.ACTOR, Subject.argument(Parameter.item("other", "")));

    @Test
    void actionsHappenAsAWholeOrNotAtAll() {
        long seed = Seed.of("random effects");
        var random = new Random(seed);
        int done = 0;
        int rounds = 2000;
        for (int round = 0; round < rounds; round++) {
            try (var arena = new OffHeapArena();
                    var modelArena = new OffHeapArena()) {
                long worldSeed = random.nextLong();
                World world = world(worldSeed, arena);
                World model = world(worldSeed, modelArena);
                String before = state(world);
                List<Effect> effects = effects(random);
                String[] names = {name(random), name(random), name(random)};
                boolean accepted = perform(world, effects, names);
                if (accepted) {
                    effects.stream()
                            .filter(Effect.Create.class::isInstance)
                            .forEach(effect -> apply(model, effect, names));
                    effects.stream()
                            .filter(effect -> !(effect instanceof Effect.Create))
                            .forEach(effect -> apply(model, effect, names));
                    effects.stream()
                            .filter(Effect.Remove.class::isInstance)
                            .forEach(effect -> model.remove(item(model, effect.of(), names).id()));
                    done++;
                }
                assertThat(state(world))
                        .as(
                                "seed %d, round %d: %s of %s, %s and %s",
                                seed, round, effects, names[0], names[1], names[2])
                        .isEqualTo(accepted ? state(model) : before);
            }
        }
        assertThat(done).isBetween(rounds / 10, rounds * 9 / 10);
    }

    private static String name(Random random) {
        return "i" + random.nextInt(6);
    }

    /**
     * Returns a world of six bodies. Some of them have mass, and some are scenery. If possible, one
     * is attached to another, and a spring joins two.
     */
    private static World world(long seed, OffHeapArena arena) {
        var random = new Random(seed);
        World world = new World("test", PROTOTYPE, arena);
        for (int i = 0; i < 6; i++) {
            var body = ItemDefinition.named("i" + i).at(i, random.nextInt(3), 0);
            switch (random.nextInt(3)) {
                case 0 -> body.physics("mass", 1 + random.nextInt(3));
                case 1 -> body.physics("mass", 0);
                default -> {}
            }
            world.add(body.build());
        }
        try {
            world.attach(world.find("i1").orElseThrow().id(), world.find("i0").orElseThrow().id());
            world.add(
                    ItemDefinition.named("spring")
                            .kind("spring")
                            .reference("end1", "i2")
                            .reference("end2", "i3")
                            .build());
        } catch (IllegalArgumentException impossible) {
            // Some worlds have no attached body and no spring.
        }
        return world;
    }

    private static List<Effect> effects(Random random) {
        while (true) {
            List<Effect> effects = new ArrayList<>();
            for (int i = 1 + random.nextInt(4); i > 0; i--) {
                effects.add(effect(random));
            }
            try {
                Changes.requireCompatible("test", effects);
                return effects;
            } catch (IllegalArgumentException incompatible) {
                // no world file could declare this action
            }
        }
    }

    private static Effect effect(Random random) {
        Subject of = SUBJECTS.get(random.nextInt(3));
        Subject to = SUBJECTS.get(random.nextInt(3));
        var vector = new Operand.Numbers(new double[] {random.nextInt(9), 1, 2}, Unit.ONE);
        return switch (random.nextInt(10)) {
            case 0 -> new Effect.Impulse(of, in(vector, "N*s"));
            case 1 -> new Effect.Force(of, in(vector, "N"), random.nextInt(3));
            case 2 -> new Effect.SetProperty(of, "velocity", in(vector, "m/s"));
            case 3 -> new Effect.SetLocation(of, in(vector, "m"));
            case 4 ->
                    new Effect.SetColour(
                            of, new Operand.Symbol(random.nextBoolean() ? "#102030" : "red"));
            case 5 -> new Effect.SetSymbol(of, "s" + random.nextInt(2), new Operand.Symbol("x"));
            case 6 -> new Effect.Attach(of, to);
            case 7 -> new Effect.Detach(of);
            case 8 -> new Effect.Remove(of);
            default ->
                    new Effect.Create(
                            random.nextInt(4) == 0
                                    ? ItemDefinition.named("rope")
                                            .kind("spring")
                                            .reference("end1", "i4")
                                            .reference("end2", "i5")
                                            .build()
                                    : ItemDefinition.named("new").at(1, 1, 1).build(),
                            random.nextBoolean() ? Map.of() : Map.of("semantic.s", vector));
        };
    }

    private static Operand in(Operand.Numbers numbers, String unit) {
        return new Operand.Numbers(numbers.values(), Unit.parse(unit));
    }

    private static boolean perform(World world, List<Effect> effects, String[] names) {
        var action = new DeclaredAction("test", "", List.of(Parameter.item("other", "")), effects);
        try {
            action.perform(
                    new ActionCall(
                            world,
                            1,
                            world.find(names[0]).orElseThrow(),
                            world.find(names[1]),
                            Arguments.check(action, Map.of("other", names[2]))));
            return true;
        } catch (ActionRefused refused) {
            return false;
        }
    }

    /** Applies the effect by the world's own methods; throws if it is impossible. */
    private static void apply(World model, Effect effect, String[] names) {
        Item item = item(model, effect.of(), names);
        switch (effect) {
            case Effect.Impulse impulse -> {
                double[] v = item.physics().vector("velocity");
                double[] kick = ((Operand.Numbers) impulse.impulse()).values();
                for (int i = 0; i < 3; i++) {
                    v[i] += kick[i] / item.physics().scalar("mass");
                }
                item.physics().set("velocity", v);
            }
            case Effect.Force force -> {
                double[] n = ((Operand.Numbers) force.force()).values();
                model.forces()
                        .add(
                                new Force(
                                        item.id(),
                                        List.of(n[0], n[1], n[2]),
                                        Math.max(1, Math.round(force.seconds()))));
            }
            case Effect.SetProperty set ->
                    item.physics().set(set.property(), ((Operand.Numbers) set.to()).values());
            case Effect.SetLocation set -> {
                double[] at = ((Operand.Numbers) set.to()).values();
                item.physical().setLocation(at[0], at[1], at[2]);
            }
            case Effect.SetColour set ->
                    item.physical()
                            .setColour(Colour.parse((String) ((Operand.Symbol) set.to()).value()));
            case Effect.SetSymbol set ->
                    item.semantic().set(set.symbol(), ((Operand.Symbol) set.to()).value());
            case Effect.Attach attach ->
                    model.attach(item.id(), item(model, attach.to(), names).id());
            case Effect.Detach detach -> model.detach(item.id());
            case Effect.Remove remove -> {} // last, see below
            case Effect.Create create -> {
                var copy =
                        create.definition()
                                .copy(create.definition().name() + "-" + (model.lastId() + 1));
                create.with()
                        .forEach(
                                (name, value) ->
                                        copy.symbol("s", ((Operand.Numbers) value).values()[0]));
                model.add(copy.build());
            }
            default -> throw new IllegalStateException(effect.toString());
        }
    }

    private static Item item(World world, Subject of, String[] names) {
        int which = SUBJECTS.indexOf(of);
        return world.find(names[which]).orElseThrow();
    }

    private static String state(World world) {
        var state = new StringBuilder(world.forces().active().toString()).append('\n');
        for (Item item : world.items()) {
            if (!item.kind().equals(WorldPrototype.WORLD)) {
                state.append(item.id()).append(Optional.of(WRITER.write(item.definition())));
            }
        }
        return state.toString();
    }
}
