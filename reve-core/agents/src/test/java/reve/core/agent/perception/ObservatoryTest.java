// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.access.DeclaredAction;
import reve.core.access.Effect;
import reve.core.access.Terms;
import reve.core.agent.protocol.Bytes;
import reve.core.agent.protocol.ClientMessage;
import reve.core.agent.protocol.Encoding;
import reve.core.agent.protocol.Json;
import reve.core.derive.BoundingBoxes;
import reve.core.unit.Unit;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Parameter;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import tools.jackson.databind.JsonNode;

import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.Random;
import java.util.concurrent.atomic.AtomicInteger;

class ObservatoryTest {
    private static JsonNode perceived(boolean relations) {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            var take =
                    new DeclaredAction(
                            "take",
                            "",
                            List.of(
                                    Parameter.number("speed", 1, Unit.parse("m/s"), "")
                                            .within(0, 2),
                                    Parameter.item("to", "")),
                            new Terms(List.of("grip"), List.of()),
                            List.of(new Effect.Raise("taken", "take")));
            world.add(ItemDefinition.named("table").shape(Shape.box(1, 1, 1)).build());
            world.add(
                    ItemDefinition.named("cup")
                            .shape(Shape.box(0.1, 0.1, 0.1))
                            .at(0, 0.55, 0)
                            .symbol("tags", List.of("red", 2, true))
                            .action(take)
                            .build());
            world.add(ItemDefinition.named("hand").capability("grip").capability("push").build());
            new BoundingBoxes().update(world);
            var ring = new SnapshotRing(world, 2);
            ring.publish(1, 0.1);
            try (var snapshot = ring.acquireLatest().orElseThrow()) {
                var observatory = new Observatory();
                assertThat(observatory.read(snapshot)).isTrue();
                View all = observatory.everything();
                View view = relations ? withRelations(observatory, new FrameRelations()) : all;
                var out = new Bytes();
                new PerceptionEncoder()
                        .write(
                                out,
                                new Difference(),
                                Encoding.JSON,
                                ClientMessage.NO_ID,
                                view,
                                null);
                return Json.MAPPER
                        .readTree(new String(out.toArray(), StandardCharsets.UTF_8))
                        .get("items");
            }
        }
    }

    @Test
    void actionsTellTheirRangesAndNeedsAndBodiesWhatTheyCanDo() {
        JsonNode items = perceived(false);

        JsonNode cup = items.get(1);
        assertThat(cup.get("actions").get("take"))
                .hasToString(
                        "{\"speed\":{\"type\":\"number\","
                                + "\"components\":1,\"unit\":\"m/s\",\"min\":0.0,\"max\":2.0},"
                                + "\"to\":{\"type\":\"item\"}}");
        assertThat(cup.get("needs")).hasToString("{\"take\":[\"grip\"]}");
        assertThat(cup.has("capabilities")).isFalse();
        assertThat(cup.get("symbols").get("tags")).hasToString("[\"red\",2.0,true]");
        assertThat(items.get(2).get("capabilities")).hasToString("[\"grip\",\"push\"]");
        assertThat(items.get(2).has("needs")).isFalse();
    }

    @Test
    void relationsAreWorkedOutOnceInAFrameAndUnchangedItemsStayTheSame() {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            Item table = world.add(ItemDefinition.named("table").shape(Shape.box(1, 1, 1)).build());
            Item cup =
                    world.add(
                            ItemDefinition.named("cup")
                                    .shape(Shape.box(0.1, 0.1, 0.1))
                                    .at(0, 0.55, 0)
                                    .build());
            world.add(ItemDefinition.named("tree").shape(Shape.box(1, 4, 1)).at(9, 2, 0).build());
            var boxes = new BoundingBoxes();
            var ring = new SnapshotRing(world, 2);
            var observatory = new Observatory();
            var found = new FrameRelations();
            List<PerceivedItem> first = related(observatory, found, world, boxes, ring, 1);
            assertThat(related(observatory, found, world, boxes, ring, 2)).isEqualTo(first);
            cup.physical().setLocation(3, 0.05, 0);
            List<PerceivedItem> moved = related(observatory, found, world, boxes, ring, 3);
            assertThat(moved.getFirst().id()).isEqualTo(table.id());
            assertThat(moved.getFirst())
                    .as("nothing is on it any more")
                    .isNotSameAs(first.getFirst());
            assertThat(moved.getFirst().relations().get("near")).isEmpty();
            assertThat(moved.get(1)).isNotSameAs(first.get(1));
            assertThat(moved.get(2)).as("the tree").isSameAs(first.get(2));
        }
    }

    private static List<PerceivedItem> related(
            Observatory observatory,
            FrameRelations relations,
            World world,
            BoundingBoxes boxes,
            SnapshotRing ring,
            long frame) {
        boxes.update(world);
        ring.publish(frame, 0.1 * frame);
        try (var snapshot = ring.acquireLatest().orElseThrow()) {
            assertThat(observatory.read(snapshot)).isTrue();
            View view = withRelations(observatory, relations);
            assertThat(relations.addTo(observatory.everything())).isSameAs(view);
            return view.items();
        }
    }

    private static View withRelations(Observatory observatory, FrameRelations relations) {
        observatory.begin(relations);
        relations.complete();
        return relations.addTo(observatory.everything());
    }

    @Test
    void relationsAreToldToWhoAsksForThem() {
        assertThat(perceived(false).get(1).get("symbols").has("on")).isFalse();

        JsonNode items = perceived(true);
        assertThat(items.get(1).get("symbols").get("on")).hasToString("[\"table\"]");
        assertThat(items.get(0).get("symbols").get("on")).hasToString("[]");
        assertThat(items.get(0).get("symbols").get("near")).hasToString("[\"cup\"]");
        assertThat(items.get(1).get("symbols").get("name").stringValue()).isEqualTo("cup");
        assertThat(items.get(2).get("symbols").has("on")).isFalse();
    }

    /** All items drift or rest. Sometimes an item jumps, turns, is added or is removed. */
    @Test
    void whatIsSensedDoesNotDependOnWhatWasAroundInEarlierFrames() {
        long seed = Seed.of("what drifts");
        var random = new Random(seed);
        var sensors =
                List.of(
                        Sensor.sight("eyes", 4),
                        Sensor.touch("skin").withRange(0.5),
                        Sensor.sight("far", 8).withFieldOfView(2),
                        Sensor.sight("sharp", 3).withLineOfSight());
        int changes = 0;
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            for (int i = 0; i < 150; i++) {
                world.add(thing(random, "thing-" + i));
            }
            var remembering =
                    world.items().stream()
                            .filter(item -> !item.kind().equals("world"))
                            .limit(10)
                            .map(item -> new Senses(item.id(), sensors))
                            .toList();
            var ring = new SnapshotRing(world, 2);
            var observatory = new Observatory();
            var last = new ArrayList<List<String>>();
            for (int frame = 1; frame <= 120; frame++) {
                drift(random, world, frame, random.nextInt(3) * 0.03);
                new BoundingBoxes().update(world);
                ring.publish(frame, frame);
                var fresh = new Observatory();
                try (var snapshot = ring.acquireLatest().orElseThrow()) {
                    assertThat(observatory.read(snapshot) && fresh.read(snapshot)).isTrue();
                }
                var sensed = new ArrayList<List<String>>();
                for (Senses senses : remembering) {
                    List<String> names =
                            senses.look(observatory).items().stream()
                                    .map(PerceivedItem::name)
                                    .toList();
                    List<String> expected =
                            new Senses(senses.body(), sensors)
                                    .look(fresh).items().stream().map(PerceivedItem::name).toList();
                    assertThat(names).as("seed %d frame %d", seed, frame).isEqualTo(expected);
                    sensed.add(names);
                }
                changes += sensed.equals(last) ? 0 : 1;
                last = sensed;
            }
        }
        assertThat(changes).isGreaterThan(30);
    }

    /**
     * Each slice of a look has time for only a few items. Other clients look between the slices,
     * and sometimes a new frame comes before the look is complete.
     */
    @Test
    void aLookInSlicesSensesWhatAnUninterruptedOneSenses() {
        long seed = Seed.of("what is looked at in slices");
        var random = new Random(seed);
        var sensors =
                List.of(
                        Sensor.sight("eyes", 4),
                        Sensor.sight("sharp", 6).withLineOfSight(),
                        Sensor.sight("far", Double.POSITIVE_INFINITY).withFieldOfView(2),
                        Sensor.sight("keen", Double.POSITIVE_INFINITY).withLineOfSight());
        int longest = 0;
        int interrupted = 0;
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            for (int i = 0; i < 150; i++) {
                world.add(thing(random, "thing-" + i));
            }
            List<Item> bodies =
                    world.items().stream()
                            .filter(item -> !item.kind().equals("world"))
                            .limit(2)
                            .toList();
            var sliced = new Senses(bodies.getFirst().id(), sensors);
            var other = new Senses(bodies.getLast().id(), sensors);
            var ring = new SnapshotRing(world, 2);
            var observatory = new Observatory();
            for (int frame = 1; frame <= 60; frame++) {
                drift(random, world, frame, random.nextInt(3) * 0.03);
                new BoundingBoxes().update(world);
                ring.publish(frame, frame);
                var fresh = new Observatory();
                try (var snapshot = ring.acquireLatest().orElseThrow()) {
                    assertThat(observatory.read(snapshot) && fresh.read(snapshot)).isTrue();
                }
                int limit = frame % 4 == 0 ? 3 : 10_000;
                Optional<View> view = Optional.empty();
                int slices = 0;
                while (view.isEmpty() && slices < limit) {
                    var readings = new AtomicInteger();
                    view = sliced.look(observatory, () -> readings.incrementAndGet() < 3);
                    slices++;
                    other.look(observatory);
                }
                longest = Math.max(longest, slices);
                assertThat(view.isPresent() || frame % 4 == 0).as("complete").isTrue();
                if (view.isEmpty()) {
                    interrupted++;
                    continue;
                }
                List<String> expected =
                        new Senses(sliced.body(), sensors)
                                .look(fresh).items().stream().map(PerceivedItem::name).toList();
                assertThat(view.get().items().stream().map(PerceivedItem::name).toList())
                        .as("seed %d frame %d", seed, frame)
                        .isEqualTo(expected);
            }
        }
        assertThat(longest).as("slices of the longest look").isGreaterThan(10);
        assertThat(interrupted).as("looks that a new frame interrupted").isGreaterThan(5);
    }

    @Test
    void aBallThatOnlyTurnsIsSensedAsItIsTurned() {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            Item eye = world.add(ItemDefinition.named("eye").sensor(Sensor.sight("s", 4)).build());
            Item ball =
                    world.add(
                            ItemDefinition.named("ball")
                                    .shape(Shape.sphere(1))
                                    .at(2, 0, 0)
                                    .build());
            var senses = new Senses(eye.id(), eye.sensors());
            var ring = new SnapshotRing(world, 2);
            var observatory = new Observatory();
            for (int frame = 1; frame <= 3; frame++) {
                ball.physical().setOrientation(0, frame == 1 ? 0 : 1, 0, frame == 1 ? 1 : 0);
                new BoundingBoxes().update(world);
                ring.publish(frame, frame);
                try (var snapshot = ring.acquireLatest().orElseThrow()) {
                    assertThat(observatory.read(snapshot)).isTrue();
                }
                assertThat(senses.look(observatory).items().get(1).place())
                        .containsExactly(2, 0, 0, 0, frame == 1 ? 0 : 1, 0, frame == 1 ? 1 : 0);
            }
        }
    }

    private static ItemDefinition thing(Random random, String name) {
        return ItemDefinition.named(name)
                .shape(Shape.box(0.5, 1, random.nextDouble(0.1, 2)))
                .at(random.nextDouble(-8, 8), random.nextDouble(-8, 8), random.nextDouble(-8, 8))
                .build();
    }

    private static void drift(Random random, World world, int frame, double way) {
        for (Item item : world.items()) {
            if (!item.kind().equals("world")) {
                double[] at = item.physical().location();
                for (int axis = 0; axis < 3; axis++) {
                    at[axis] += ((item.id().value() * 31 + axis) % 3 - 1) * way;
                }
                item.physical().setLocation(at[0], at[1], at[2]);
            }
        }
        switch (random.nextInt(20)) {
            case 0 -> world.add(thing(random, "new-" + frame));
            case 1 -> world.remove(world.find("thing-" + (149 - frame)).orElseThrow().id());
            case 2 ->
                    world.find("thing-20")
                            .orElseThrow()
                            .physical()
                            .setLocation(
                                    random.nextBoolean() ? 1e30 : random.nextDouble(-8, 8), 0, 0);
            case 3, 4, 5, 6 ->
                    world.find("thing-" + random.nextInt(10))
                            .orElseThrow()
                            .physical()
                            .setOrientation(
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    1);
            default -> {}
        }
    }
}
