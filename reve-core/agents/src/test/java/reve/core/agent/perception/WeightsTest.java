// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.derive.BoundingBoxes;
import reve.core.unit.Unit;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.SnapshotRing;
import reve.core.world.SymbolDescriptor;
import reve.core.world.SymbolType;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;
import java.util.Random;

/** What is too heavy for a body, while masses, strengths, places and items change. */
class WeightsTest {
    private static final WorldPrototype PROTOTYPE =
            WorldPrototype.standard("si-f64")
                    .withSymbols(
                            List.of(
                                    new SymbolDescriptor(
                                            "strength",
                                            SymbolType.NUMBER,
                                            Unit.parse("N"),
                                            "What the body lifts.")));
    private static final double GRAVITY = 10;

    private final Observatory observatory = new Observatory(PROTOTYPE);

    private void publish(SnapshotRing ring, World world, long frame) {
        new BoundingBoxes().update(world);
        ring.publish(frame, frame);
        try (var snapshot = ring.acquireLatest().orElseThrow()) {
            assertThat(observatory.read(snapshot)).isTrue();
        }
    }

    private static World world(OffHeapArena arena) {
        World world = new World("w", PROTOTYPE, arena);
        world.find("world").orElseThrow().physics().set("gravity", 0, -GRAVITY, 0);
        return world;
    }

    @Test
    void eachFrameHasTheWeightsOfItsMasses() {
        var random = new Random(Seed.of("what is too heavy"));
        try (var arena = new OffHeapArena()) {
            World world = world(arena);
            List<Item> bodies = new ArrayList<>();
            for (int i = 0; i < 30; i++) {
                bodies.add(add(world, "b" + i, random));
            }
            var ring = new SnapshotRing(world, 2);
            List<Weighed> before = new ArrayList<>();
            bodies.forEach(each -> before.add(Weighed.NOTHING));
            for (int frame = 1; frame <= 200; frame++) {
                change(world, bodies, before, random, frame);
                publish(ring, world, frame);
                for (int i = 0; i < bodies.size(); i++) {
                    Item body = bodies.get(i);
                    List<PerceivedItem> all = observatory.everything().items();
                    Weighed now = observatory.weigh(body.id(), all, before.get(i));
                    before.set(i, now);
                    double strength = (Double) body.semantic().get("strength").orElseThrow();
                    for (PerceivedItem seen : now.items()) {
                        Item item = world.item(seen.id());
                        assertThat(seen.isTooHeavy())
                                .as("frame %s: %s for %s", frame, item, body)
                                .isEqualTo(
                                        item != body
                                                && item.physics().scalar("mass") * GRAVITY
                                                        > strength);
                    }
                }
            }
        }
    }

    private static Item add(World world, String name, Random random) {
        return world.add(
                ItemDefinition.named(name)
                        .physics("mass", random.nextInt(10))
                        .symbol("strength", 10.0 * random.nextInt(10))
                        .build());
    }

    private static void change(
            World world, List<Item> bodies, List<Weighed> before, Random random, int frame) {
        int which = random.nextInt(bodies.size());
        Item body = bodies.get(which);
        switch (random.nextInt(5)) {
            case 0 -> body.physics().set("mass", random.nextInt(10));
            case 1 -> body.semantic().set("strength", 10.0 * random.nextInt(10));
            case 2 -> body.physical().setLocation(random.nextDouble(), 0, 0);
            case 3 -> {
                world.remove(body.id());
                bodies.set(which, add(world, "new" + frame, random));
                before.set(which, Weighed.NOTHING);
            }
            default -> {}
        }
    }

    /** A frame in which nothing changes costs nothing. */
    @Test
    void theSameItemsAreNotWeighedAgain() {
        try (var arena = new OffHeapArena()) {
            World world = world(arena);
            Item child =
                    world.add(
                            ItemDefinition.named("child")
                                    .physics("mass", 1)
                                    .symbol("strength", 40.0)
                                    .build());
            Item chest = world.add(ItemDefinition.named("chest").physics("mass", 5).build());
            var ring = new SnapshotRing(world, 2);
            publish(ring, world, 1);
            List<PerceivedItem> all = observatory.everything().items();
            Weighed first = observatory.weigh(child.id(), all, Weighed.NOTHING);
            assertThat(first.items().getLast().isTooHeavy()).isTrue();
            publish(ring, world, 2);
            assertThat(observatory.weigh(child.id(), all, first)).isSameAs(first);
            chest.physics().set("mass", 4);
            publish(ring, world, 3);
            assertThat(observatory.weigh(child.id(), all, first).items()).isSameAs(all);
        }
    }
}
