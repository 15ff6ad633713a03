// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;
import reve.core.derive.DerivedColumns;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;

import java.util.Arrays;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.Random;
import java.util.Set;
import java.util.TreeMap;
import java.util.stream.Collectors;

/**
 * The changes of each frame alone reproduce the world. The random histories change the world in
 * ACT, between frames and in PUBLISH. Seeds are printed. The seed 0 stands for a new seed.
 */
class WorldMirrorTest {
    private static final int FRAMES = 150;

    private Random random = new Random();
    private World world = new World("w", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private int made;

    @ParameterizedTest
    @CsvSource({"si-f64, 1, 1e-9", "si-f32, 2, 1e-3", "si-f64, 0, 1e-9", "si-f32, 0, 1e-3"})
    void aMirrorOfTheChangesIsTheWorldAfterEveryFrame(
            String prototype, long given, double tolerance) {
        long seed = Seed.of("histories in " + prototype, given);
        random = new Random(seed);
        world = new World("w", WorldPrototype.standard(prototype), new OffHeapArena());
        var mirror = new WorldMirror(world.prototype());
        var bus = new FrameBus();
        DerivedColumns.subscribeTo(bus);
        bus.subscribe(FramePhase.ACT, "actor", event -> change(8));
        bus.subscribe(
                FramePhase.PUBLISH,
                "mirror",
                event -> {
                    mirror.follow(world.changes(), world);
                    check(mirror, tolerance, "seed " + seed + " frame " + event.frame());
                });
        bus.subscribe(
                FramePhase.PUBLISH,
                "late",
                event ->
                        bodies().stream()
                                .limit(2)
                                .forEach(
                                        body ->
                                                body.semantic()
                                                        .set("late", (double) event.frame())));
        var loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);
        for (int frame = 0; frame < FRAMES; frame++) {
            loop.step();
            change(2);
        }
        assertThat(mirror.items())
                .as("a history of seed %d that is no trifle", seed)
                .hasSizeGreaterThan(5);
    }

    private void check(WorldMirror mirror, double tolerance, String when) {
        Map<ItemId, Item> items =
                world.items().stream()
                        .filter(item -> !item.kind().equals(WorldPrototype.WORLD))
                        .collect(Collectors.toMap(Item::id, item -> item));
        assertThat(world.events()).as("faults of listeners, " + when).isEmpty();
        assertThat(Set.copyOf(mirror.items().keySet())).as(when).isEqualTo(items.keySet());
        mirror.items()
                .forEach(
                        (id, mirrored) -> {
                            Item item = items.get(id);
                            String what = when + " " + item;
                            assertThat(mirrored.name).as(what).isEqualTo(item.name());
                            assertThat(mirrored.kind).as(what).isEqualTo(item.kind());
                            assertThat(mirrored.symbols).as(what).isEqualTo(item.symbols().given());
                            assertThat(mirrored.actions.values())
                                    .as(what)
                                    .containsExactlyInAnyOrderElementsOf(item.access().actions());
                            assertThat(mirrored.physics).as(what).isEqualTo(physics(item));
                            assertThat(Optional.ofNullable(mirrored.parent))
                                    .as(what)
                                    .isEqualTo(item.parent());
                            if (!item.physical().isEmpty()) {
                                checkPlaceAndLook(mirror, mirrored, item, tolerance, what);
                            }
                        });
    }

    private static void checkPlaceAndLook(
            WorldMirror mirror,
            WorldMirror.Mirrored mirrored,
            Item item,
            double tolerance,
            String what) {
        assertThat(mirror.place(mirrored).location())
                .as(what)
                .containsExactly(item.physical().location(), within(tolerance));
        assertThat(mirror.place(mirrored).orientation())
                .as(what)
                .containsExactly(item.physical().orientation(), within(tolerance));
        assertThat(mirrored.shape).as(what).isEqualTo(item.physical().shape());
        assertThat(mirrored.material).as(what).isEqualTo(item.physical().material());
        assertThat(mirrored.colour).as(what).isEqualTo(item.physical().colour());
    }

    private static Map<String, Object> physics(Item item) {
        Map<String, Object> physics = new TreeMap<>();
        for (String property : item.physics().properties()) {
            physics.put(
                    property,
                    item.table().physicsColumn(property).type() == ScalarType.REF
                            ? item.physics().references(property)
                            : Arrays.stream(item.physics().vector(property)).boxed().toList());
        }
        return physics;
    }

    private void change(int times) {
        for (int i = 0; i < times; i++) {
            List<Item> bodies = bodies();
            if (bodies.size() < 4) {
                world.addAll(List.of(body().build(), body().build(), body().build()));
            } else {
                change(
                        bodies.get(random.nextInt(bodies.size())),
                        bodies.get(random.nextInt(bodies.size())));
            }
        }
    }

    private void change(Item any, Item other) {
        switch (random.nextInt(16)) {
            case 0 -> world.add(body().build());
            case 1 -> addTogether(other);
            case 2 -> world.removeCascade(any.id());
            case 3 -> world.rename(any.id(), "renamed " + made++);
            case 4, 5 -> attach(any, other);
            case 6 -> {
                if (any.parent().isPresent()) {
                    world.detach(any.id());
                }
            }
            case 7 -> any.physical().setLocation(number(), number(), number());
            case 8 -> any.physical().setOrientation(number(), number(), number(), 1);
            case 9 -> look(any);
            case 10 ->
                    any.semantic()
                            .set(
                                    "mood " + random.nextInt(3),
                                    random.nextBoolean() ? "söso" : List.of(number(), true, "x"));
            case 11 -> any.semantic().remove("mood " + random.nextInt(3));
            case 12 ->
                    any.access().set(new TestAction("act " + random.nextInt(2), "no. " + made++));
            case 13 -> any.access().remove("act " + random.nextInt(2));
            case 14 -> edit(any, other);
            default -> clear(any);
        }
    }

    /** Items that refer to each other and to present ones, in an order with forward references. */
    private void addTogether(Item other) {
        ItemDefinition cart = body().physics("charge", number()).build();
        ItemDefinition wheel = body().parent(cart.name()).build();
        var spring =
                ItemDefinition.named("spring " + made++)
                        .kind("spring")
                        .physics("length", random.nextFloat())
                        .reference("end1", cart.name())
                        .reference("end2", other.physics().isEmpty() ? cart.name() : other.name());
        world.addAll(List.of(spring.build(), wheel, cart));
    }

    private ItemDefinition.Builder body() {
        var body =
                ItemDefinition.named("body " + made++)
                        .at(number(), number(), number())
                        .orientation(number(), number(), number(), 1)
                        .symbol("class", "thing");
        if (random.nextBoolean()) {
            body.action(new TestAction("act 0", "at first"));
        }
        return random.nextBoolean() ? body : body.physics("velocity", 0, random.nextFloat(), -0.0);
    }

    private void attach(Item child, Item parent) {
        for (Optional<Item> above = Optional.of(parent);
                above.isPresent();
                above = above.get().parent().map(world::item)) {
            if (above.get() == child) {
                return;
            }
        }
        if (!child.physics().isEmpty() && child.physics().scalar("mass") != 0) {
            return;
        }
        if (random.nextBoolean()) {
            world.attach(child.id(), parent.id());
        } else {
            world.attach(
                    child.id(),
                    parent.id(),
                    Pose.of(
                            new double[] {number(), number(), number()},
                            new double[] {number(), 0, 1, 1}));
        }
    }

    private void look(Item item) {
        switch (random.nextInt(3)) {
            case 0 -> item.physical().setColour(new Colour(random.nextInt()));
            case 1 ->
                    item.physical()
                            .setMaterial(
                                    random.nextBoolean()
                                            ? Optional.empty()
                                            : Optional.of(
                                                    new Material(
                                                            Colour.WHITE,
                                                            random.nextDouble(),
                                                            0,
                                                            Optional.empty())));
            default ->
                    item.physical()
                            .setShape(
                                    random.nextBoolean()
                                            ? Shape.none()
                                            : Shape.box(1, random.nextDouble() + 0.1, 3));
        }
    }

    private void edit(Item any, Item other) {
        switch (random.nextInt(3)) {
            case 0 -> any.physics().set("externalForce", number(), 0.1, number());
            case 1 -> {
                Table bodies = world.table(WorldPrototype.BODY);
                if (bodies.physicsRowCount() > 0) {
                    bodies.column("charge")
                            .setDouble(random.nextInt(bodies.physicsRowCount()), 0, number());
                }
            }
            default ->
                    world.items().stream()
                            .filter(item -> item.kind().equals("spring"))
                            .filter(_ -> !other.physics().isEmpty())
                            .findFirst()
                            .ifPresent(
                                    spring -> spring.physics().setReferences("end2", other.id()));
        }
    }

    private static void clear(Item item) {
        if (!item.world().references.isReferredTo(item.id())) {
            item.physics().clear();
        }
    }

    private double number() {
        return random.nextGaussian();
    }

    private List<Item> bodies() {
        return world.items().stream().filter(item -> !item.physical().isEmpty()).toList();
    }
}
