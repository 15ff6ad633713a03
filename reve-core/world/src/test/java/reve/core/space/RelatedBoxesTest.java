// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.Comparator;
import java.util.List;
import java.util.Random;
import java.util.stream.IntStream;

/** The relations that the tree finds equal those of a comparison of all pairs. */
class RelatedBoxesTest {
    private static final double TOLERANCE = 0.01;

    private final RelatedBoxes related = new RelatedBoxes();

    private double[] lows = {};
    private double[] highs = {};

    /** Sets of boxes. Each relation occurs in them more often than the limit of results. */
    private enum Scene {
        /** Cubes of a few sizes on a grid, so that faces meet. */
        GRID {
            @Override
            void place(Random random, int i, double[] middle, double[] size) {
                double edge = Math.pow(2, random.nextInt(-2, 3));
                for (int axis = 0; axis < 3; axis++) {
                    size[axis] = edge;
                    middle[axis] = 0.5 * random.nextInt(0, 16) + 0.5 * edge;
                }
            }
        },
        /** Boxes inside each other. Most of them have a common corner or centre. */
        NESTED {
            @Override
            void place(Random random, int i, double[] middle, double[] size) {
                for (int axis = 0; axis < 3; axis++) {
                    size[axis] = Math.exp(random.nextDouble(-3, 3));
                    middle[axis] = random.nextInt(3) * 0.5 * size[axis];
                }
            }
        },
        /** Boxes that are almost at the same place, in no order. */
        CROWD {
            @Override
            void place(Random random, int i, double[] middle, double[] size) {
                for (int axis = 0; axis < 3; axis++) {
                    size[axis] = 1;
                    middle[axis] = 0.6 * random.nextDouble() * random.nextInt(2);
                }
            }
        },
        /** Boxes that are each long along one axis. They cross, and none contains another. */
        RODS {
            @Override
            void place(Random random, int i, double[] middle, double[] size) {
                for (int axis = 0; axis < 3; axis++) {
                    size[axis] = 0.1;
                    middle[axis] = random.nextDouble(-0.2, 0.2);
                }
                size[i % 3] = 5 + random.nextDouble();
            }
        },
        /** Boxes from tiny ones to boxes that are so far away that doubles are coarse. */
        FAR {
            @Override
            void place(Random random, int i, double[] middle, double[] size) {
                for (int axis = 0; axis < 3; axis++) {
                    size[axis] = Math.pow(10, random.nextInt(-170, 10));
                    middle[axis] = random.nextInt(2) * Math.pow(10, random.nextInt(-20, 101));
                }
            }
        };

        abstract void place(Random random, int i, double[] middle, double[] size);
    }

    private void place(Scene scene, Random random, int i) {
        double[] middle = new double[3];
        double[] size = new double[3];
        scene.place(random, i, middle, size);
        for (int axis = 0; axis < 3; axis++) {
            lows[3 * i + axis] = middle[axis] - 0.5 * size[axis];
            highs[3 * i + axis] = middle[axis] + 0.5 * size[axis];
        }
    }

    @Test
    void findsWhatAComparisonOfAllPairsFinds() {
        long seed = Seed.of("related boxes");
        var random = new Random(seed);
        int[] seen = new int[RelatedBoxes.RELATIONS];
        for (Scene scene : Scene.values()) {
            for (int count : new int[] {1, 2, 9, 70, 300}) {
                lows = new double[3 * count];
                highs = new double[3 * count];
                for (int i = 0; i < count; i++) {
                    place(scene, random, i);
                }
                for (int moment = 0; moment < 4; moment++) {
                    assertThat(related.load(lows, highs, count)).isTrue();
                    for (int box = 0; box < count; box++) {
                        related.find(box);
                        for (int relation = 0; relation < RelatedBoxes.RELATIONS; relation++) {
                            assertThat(found(relation))
                                    .as(
                                            "seed %d, %s, %d boxes, box %d, relation %d",
                                            seed, scene, count, box, relation)
                                    .isEqualTo(expected(relation, box, count));
                            seen[relation] += related.found(relation);
                        }
                    }
                    for (int moves = 0; moves < 1 + count / 10; moves++) {
                        place(scene, random, random.nextInt(count));
                    }
                    lows[0] -= (moment + 1) * 1e-3 * (highs[0] - lows[0]) + Math.ulp(lows[0]);
                }
            }
        }
        assertThat(Arrays.stream(seen)).allMatch(number -> number > 1000);
    }

    @Test
    void saysWhetherBoxesAreTheSameAsBefore() {
        double[] low = {0, 0, 0, 2, 0, 0};
        double[] high = {1, 1, 1, 3, 1, 1};
        assertThat(related.load(low, high, 2)).isTrue();
        assertThat(related.load(low, high, 2)).isFalse();
        high[3] = 3.5;
        assertThat(related.load(low, high, 2)).isTrue();
        assertThat(related.load(low, high, 1)).isTrue();
        related.find(0);
        assertThat(found(RelatedBoxes.NEAR)).isEmpty();
    }

    private List<Integer> found(int relation) {
        return IntStream.range(0, related.found(relation))
                .mapToObj(place -> related.found(relation, place))
                .toList();
    }

    private List<Integer> expected(int relation, int box, int count) {
        var others = new ArrayList<Integer>();
        for (int other = 0; other < count; other++) {
            if (other != box && holds(relation, box, other)) {
                others.add(other);
            }
        }
        others.sort(
                Comparator.comparingDouble((Integer other) -> gap(box, other))
                        .thenComparing(Comparator.naturalOrder()));
        return others.stream().limit(RelatedBoxes.MOST).toList();
    }

    private boolean holds(int relation, int a, int b) {
        double size = Math.min(diagonal(a), diagonal(b));
        double tolerance = TOLERANCE * size;
        boolean isClose = isWithin(a, b, TOLERANCE * diagonal(a));
        return switch (relation) {
            case RelatedBoxes.NEAR -> isWithin(a, b, diagonal(a)) && gap(a, b) <= size;
            case RelatedBoxes.TOUCHING -> isClose && gap(a, b) <= tolerance;
            case RelatedBoxes.ON ->
                    isClose
                            && Math.abs(lows[3 * a + 1] - highs[3 * b + 1]) <= tolerance
                            && overlap(a, b, 0)
                            && overlap(a, b, 2);
            default ->
                    isClose
                            && diagonal(a) < diagonal(b)
                            && IntStream.range(0, 3)
                                    .allMatch(
                                            axis ->
                                                    lows[3 * a + axis]
                                                                    >= lows[3 * b + axis]
                                                                            - tolerance
                                                            && highs[3 * a + axis]
                                                                    <= highs[3 * b + axis]
                                                                            + tolerance);
        };
    }

    /** Returns whether one box, enlarged on all sides, meets the other. */
    private boolean isWithin(int a, int b, double by) {
        return IntStream.range(0, 3)
                .allMatch(
                        axis ->
                                lows[3 * b + axis] <= highs[3 * a + axis] + by
                                        && highs[3 * b + axis] >= lows[3 * a + axis] - by);
    }

    private boolean overlap(int a, int b, int axis) {
        return Math.min(highs[3 * a + axis], highs[3 * b + axis])
                > Math.max(lows[3 * a + axis], lows[3 * b + axis]);
    }

    private double gap(int a, int b) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            double apart =
                    Math.max(
                            0,
                            Math.max(
                                    lows[3 * b + axis] - highs[3 * a + axis],
                                    lows[3 * a + axis] - highs[3 * b + axis]));
            sum += apart * apart;
        }
        return Math.sqrt(sum);
    }

    private double diagonal(int box) {
        double x = highs[3 * box] - lows[3 * box];
        double y = highs[3 * box + 1] - lows[3 * box + 1];
        double z = highs[3 * box + 2] - lows[3 * box + 2];
        return Math.sqrt(x * x + y * y + z * z);
    }
}
