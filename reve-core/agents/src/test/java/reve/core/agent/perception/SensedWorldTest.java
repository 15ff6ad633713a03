// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;
import reve.core.derive.BoundingBoxes;
import reve.core.world.ItemDefinition;
import reve.core.world.OffHeapArena;
import reve.core.world.Sensor;
import reve.core.world.Shape;
import reve.core.world.Table;
import reve.core.world.World;
import reve.core.world.WorldPrototype;

import java.util.Random;

/** The tree of boxes finds what hides an item; the test compares it with a search of every box. */
class SensedWorldTest {

    private static final double REACH = 12;
    private static final double END = 1e-9;

    private final Sensor sensor = Sensor.sight("eyes", REACH).withLineOfSight();

    @Test
    void anItemIsSeenExactlyIfNoBoxOfAllThatThereAreHidesAllOfItsPoints() {
        long seed = Seed.of("boxes");
        var random = new Random(seed);
        int seen = 0;
        int hidden = 0;
        for (int items : new int[] {1, 2, 9, 70, 400}) {
            try (var arena = new OffHeapArena()) {
                World world = new World("test", WorldPrototype.standard("si-f64"), arena);
                for (int i = 0; i < items; i++) {
                    world.add(item(random, "item-" + i));
                }
                new BoundingBoxes().update(world);
                Table bodies = world.table(WorldPrototype.BODY);
                var sensed = new SensedWorld();
                sensed.load(bodies);
                for (int pair = 0; pair < 400; pair++) {
                    int eye = random.nextInt(items);
                    int row = random.nextInt(items);
                    boolean sees = sees(bodies, eye, row);
                    assertThat(sensed.senses(sensor, eye, row))
                            .as("seed %d, %d items, %d sees %d", seed, items, eye, row)
                            .isEqualTo(sees);
                    seen += sees ? 1 : 0;
                    hidden += sees ? 0 : 1;
                }
            }
        }
        assertThat(seen).isGreaterThan(200);
        assertThat(hidden).isGreaterThan(200);
    }

    @Test
    void anItemThatWasCreatedInThisFrameIsNotSeenYet() {
        try (var arena = new OffHeapArena()) {
            World world = new World("test", WorldPrototype.standard("si-f64"), arena);
            world.add(ItemDefinition.named("eye").build());
            new BoundingBoxes().update(world);
            world.add(ItemDefinition.named("crumb").at(1, 0, 0).build());
            Table bodies = world.table(WorldPrototype.BODY);
            var sensed = new SensedWorld();
            sensed.load(bodies);
            assertThat(sensed.senses(sensor, 0, 1)).isFalse();
            assertThat(sensed.senses(Sensor.touch("skin"), 0, 1)).isFalse();
            new BoundingBoxes().update(world);
            sensed.load(bodies);
            assertThat(sensed.senses(sensor, 0, 1)).isTrue();
        }
    }

    /**
     * Returns an item. Some items are on a grid, so that lines run along faces and through corners.
     */
    private static ItemDefinition item(Random random, String name) {
        ItemDefinition.Builder item = ItemDefinition.named(name);
        if (random.nextBoolean()) {
            item.at(random.nextInt(-5, 6), random.nextInt(-5, 6), random.nextInt(-5, 6));
        } else {
            item.at(random.nextDouble(-5, 5), random.nextDouble(-5, 5), random.nextDouble(-5, 5));
        }
        return switch (random.nextInt(4)) {
            case 0 -> item.build();
            case 1 -> item.shape(Shape.box(1, 1, 1)).build();
            case 2 -> item.shape(Shape.sphere(random.nextDouble(0.1, 1))).build();
            default ->
                    item.shape(Shape.box(random.nextDouble(0.1, 4), 0.5, random.nextDouble(0.1, 4)))
                            .orientation(
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    random.nextGaussian(),
                                    1)
                            .build();
        };
    }

    /**
     * Returns whether a point of the box is in reach and not hidden. The points are the nearest
     * point, the middle and the corners.
     */
    private static boolean sees(Table bodies, int eye, int row) {
        double[] from = read(bodies, "position", eye);
        double[] low = read(bodies, "boundsMin", row);
        double[] high = read(bodies, "boundsMax", row);
        for (int point = 0; point < 10; point++) {
            double[] to = new double[3];
            double square = 0;
            for (int axis = 0; axis < 3; axis++) {
                to[axis] =
                        point == 8
                                ? Math.clamp(from[axis], low[axis], high[axis])
                                : point == 9
                                        ? 0.5 * (low[axis] + high[axis])
                                        : (point >> axis & 1) == 0 ? low[axis] : high[axis];
                square += (to[axis] - from[axis]) * (to[axis] - from[axis]);
            }
            if (Math.sqrt(square) <= REACH && !isHidden(bodies, eye, row, from, to)) {
                return true;
            }
        }
        return false;
    }

    private static boolean isHidden(Table bodies, int eye, int row, double[] from, double[] to) {
        for (int other = 0; other < bodies.rowCount(); other++) {
            if (other != eye
                    && other != row
                    && bodies.column("shape").getInt(other, 0) != Shape.NONE
                    && isBetween(
                            from,
                            to,
                            read(bodies, "boundsMin", other),
                            read(bodies, "boundsMax", other))) {
                return true;
            }
        }
        return false;
    }

    private static boolean isBetween(double[] from, double[] to, double[] low, double[] high) {
        double enter = 0;
        double leave = 1;
        boolean holdsEye = true;
        for (int axis = 0; axis < 3; axis++) {
            double way = to[axis] - from[axis];
            boolean inside = from[axis] >= low[axis] && from[axis] <= high[axis];
            holdsEye &= inside;
            if (way == 0 && !inside) {
                return false;
            }
            if (way != 0) {
                double a = (low[axis] - from[axis]) / way;
                double b = (high[axis] - from[axis]) / way;
                enter = Math.max(enter, Math.min(a, b));
                leave = Math.min(leave, Math.max(a, b));
            }
        }
        return !holdsEye && enter <= leave && enter < 1 - END && leave > END;
    }

    private static double[] read(Table bodies, String column, int row) {
        double[] numbers = new double[3];
        for (int axis = 0; axis < 3; axis++) {
            numbers[axis] = bodies.column(column).getDouble(row, axis);
        }
        return numbers;
    }
}
