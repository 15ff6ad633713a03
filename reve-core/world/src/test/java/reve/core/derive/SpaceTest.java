// SPDX-License-Identifier: Apache-2.0
package reve.core.derive;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;
import static org.assertj.core.api.Assertions.assertThatIllegalStateException;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.ValueSource;

import reve.core.Seed;
import reve.core.frame.FrameBus;
import reve.core.frame.FrameLoop;
import reve.core.frame.FramePhase;
import reve.core.frame.Pacing;
import reve.core.frame.Timing;
import reve.core.space.Box;
import reve.core.world.Item;
import reve.core.world.ItemDefinition;
import reve.core.world.ItemId;
import reve.core.world.OffHeapArena;
import reve.core.world.Shape;
import reve.core.world.SnapshotRing;
import reve.core.world.World;
import reve.core.world.WorldImage;
import reve.core.world.WorldPrototype;

import java.util.ArrayList;
import java.util.List;
import java.util.Random;

class SpaceTest {

    private static final Box NEAR = Box.around(0, 0, 0, 10);

    private final World world =
            new World("test", WorldPrototype.standard("si-f64"), new OffHeapArena());
    private final FrameBus bus = new FrameBus();
    private final FrameLoop loop = new FrameLoop(world, bus, Timing.DEFAULT, Pacing.FAST);

    SpaceTest() {
        DerivedColumns.subscribeTo(bus);
    }

    private Item ball(String name, double x, double radius) {
        return world.add(
                ItemDefinition.named(name).at(x, 0, 0).shape(Shape.sphere(radius)).build());
    }

    @Test
    void findsBodiesByRegionAndByDistance() {
        Item far = ball("far", 12, 1);
        Item near = ball("near", 5, 1);
        Item point = world.add(ItemDefinition.named("point").at(10, 0, 0).build());
        loop.step();
        assertThat(world.space().inBox(NEAR)).containsExactly(near.id(), point.id());
        assertThat(world.space().inBox(Box.around(0, 0, 0, 11))).hasSize(3);
        assertThat(world.space().inSphere(0, 0, 0, 4)).containsExactly(near.id());
        assertThat(world.space().inSphere(0, 0, 0, 3.99)).isEmpty();
        assertThat(world.space().nearest(0, 0, 0, 2)).containsExactly(near.id(), point.id());
        assertThat(world.space().nearest(12, 0, 0, 9))
                .containsExactly(far.id(), point.id(), near.id());
    }

    @Test
    void whatChangedSinceDeriveIsSeenInTheNext() {
        Item moved = ball("moved", 0, 1);
        Item removed = ball("removed", 1, 1);
        assertThat(world.space().inBox(NEAR)).as("before the first DERIVE").isEmpty();
        loop.step();
        world.remove(removed.id());
        moved.physical().setLocation(100, 0, 0);
        Item added = ball("added", 2, 1);
        assertThat(world.space().inBox(NEAR)).containsExactly(moved.id());
        assertThat(world.space().nearest(2, 0, 0, 1)).containsExactly(moved.id());
        assertThat(added.physical().boundsMin()).containsOnly(Double.NaN);
        loop.step();
        assertThat(world.space().inBox(NEAR)).containsExactly(added.id());
    }

    /** An earlier query must not affect the result. */
    @Test
    void anIndexThatIsBuiltLateFindsTheSame() {
        ball("a", 0, 1);
        Item b = ball("b", 1, 1);
        loop.step();
        world.remove(b.id());
        ball("c", 2, 1);
        List<ItemId> late = world.space().inBox(NEAR);
        assertThat(late).containsExactly(world.find("a").orElseThrow().id());
    }

    @Test
    void aRestoredWorldFindsWhatItThenFound() {
        Item ball = ball("ball", 0, 1);
        loop.step();
        try (var image = new WorldImage(world)) {
            image.copyFrom(world, 1);
            ball.physical().setLocation(100, 0, 0);
            loop.step();
            assertThat(world.space().inBox(NEAR)).isEmpty();
            world.restore(image);
            assertThat(world.space().inBox(NEAR)).containsExactly(ball.id());
        }
    }

    @Test
    void readersAskTheirSnapshot() {
        Item ball = ball("ball", 0, 1);
        var ring = new SnapshotRing(world, 2);
        bus.subscribe(
                FramePhase.PUBLISH,
                "snapshots",
                event -> ring.publish(event.frame(), event.timeSeconds()));
        loop.step();
        var snapshot = ring.acquireLatest().orElseThrow();
        ball.physical().setLocation(100, 0, 0);
        loop.step();
        assertThat(snapshot.space().inBox(NEAR)).containsExactly(ball.id());
        assertThat(snapshot.space().nearest(100, 0, 0, 1)).containsExactly(ball.id());
        assertThat(snapshot.lost()).isFalse();
        snapshot.close();
        assertThatIllegalStateException().isThrownBy(snapshot::space);
    }

    @Test
    void nonsenseIsRefusedWithItsValue() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.space().inSphere(0, 0, 0, -1))
                .withMessage("radius is -1.0 m, expected 0 or more");
        assertThatIllegalArgumentException()
                .isThrownBy(() -> world.space().nearest(0, Double.NaN, 0, 1))
                .withMessageContaining("NaN");
    }

    @ParameterizedTest
    @ValueSource(longs = {51, 0})
    void agreesWithTheBoxesThroughRandomHistories(long givenSeed) {
        long seed = Seed.of("random histories", givenSeed);
        Random random = new Random(seed);
        List<Item> items = new ArrayList<>();
        for (int step = 0; step < 400; step++) {
            if (items.size() < 20 || random.nextInt(3) > 0) {
                items.add(
                        world.add(
                                ItemDefinition.named("i" + step)
                                        .at(
                                                random.nextDouble() * 50,
                                                random.nextDouble() * 50,
                                                random.nextDouble() * 50)
                                        .shape(Shape.box(1 + random.nextInt(5), 2, 3))
                                        .orientation(1, random.nextDouble(), 0, 1)
                                        .build()));
            } else if (random.nextBoolean()) {
                items.get(random.nextInt(items.size()))
                        .physical()
                        .setLocation(random.nextDouble() * 50, 0, 0);
            } else {
                world.remove(items.remove(random.nextInt(items.size())).id());
            }
            if (step % 3 == 0) {
                loop.step();
                Box box = Box.around(random.nextDouble() * 50, random.nextDouble() * 50, 25, 10);
                assertThat(world.space().inBox(box))
                        .as("seed %d step %d", seed, step)
                        .isEqualTo(
                                items.stream()
                                        .filter(item -> meets(item, box))
                                        .map(Item::id)
                                        .sorted()
                                        .toList());
            }
        }
    }

    private static boolean meets(Item item, Box box) {
        double[] low = item.physical().boundsMin();
        double[] high = item.physical().boundsMax();
        return low[0] <= box.maxX()
                && high[0] >= box.minX()
                && low[1] <= box.maxY()
                && high[1] >= box.minY()
                && low[2] <= box.maxZ()
                && high[2] >= box.minZ();
    }
}
