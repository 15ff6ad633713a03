// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatIllegalArgumentException;

import com.sun.management.ThreadMXBean;

import org.junit.jupiter.api.Test;
import org.junit.jupiter.params.ParameterizedTest;
import org.junit.jupiter.params.provider.CsvSource;

import reve.core.Seed;

import java.lang.foreign.Arena;
import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.lang.management.ManagementFactory;
import java.util.ArrayList;
import java.util.Comparator;
import java.util.List;
import java.util.Random;
import java.util.function.IntPredicate;
import java.util.function.LongPredicate;

class BoxIndexTest {

    private static final int MOST = 3000;

    private final MemorySegment ids = Arena.ofAuto().allocate(8L * MOST, 8);
    private final MemorySegment lows = Arena.ofAuto().allocate(24L * MOST, 8);
    private final MemorySegment highs = Arena.ofAuto().allocate(24L * MOST, 8);
    private final BoxIndex index = new BoxIndex();
    private final Found found = new Found();
    private Random random = new Random();
    private int rows;

    /** Boxes that move a little between most rounds. Some have no place, and some are far away. */
    @ParameterizedTest
    @CsvSource({"41, 3000", "42, 40", "43, 9", "44, 1", "0, 700"})
    void findsWhatLookingAtEveryBoxFinds(long givenSeed, int most) {
        long seed = Seed.of("boxes", givenSeed);
        random = new Random(seed);
        scatter(most);
        for (int round = 0; round < 30; round++) {
            if (round % 10 == 9) {
                scatter(random.nextInt(most + 1));
            }
            move();
            index.build(ids, lows, highs, rows);
            for (int query = 0; query < 20; query++) {
                check("seed " + seed + " round " + round);
            }
        }
    }

    @Test
    void anEmptyIndexFindsNothing() {
        index.build(ids, lows, highs, 0);
        index.inBox(Box.around(0, 0, 0, Double.POSITIVE_INFINITY), found);
        assertThat(found.size()).isZero();
        index.nearest(0, 0, 0, 5, found);
        assertThat(found.size()).isZero();
    }

    @Test
    void equallyNearBoxesComeInTheOrderOfTheirKeys() {
        for (int row = 0; row < 100; row++) {
            put(row, 1000 - row, row % 2 == 0 ? 5 : -5, 0, 0, 1);
        }
        index.build(ids, lows, highs, 100);
        index.nearest(0, 0, 0, 7, found);
        assertThat(keys()).containsExactly(901L, 902L, 903L, 904L, 905L, 906L, 907L);
    }

    @Test
    void aBoxWithoutOrderIsRefused() {
        assertThatIllegalArgumentException()
                .isThrownBy(() -> new Box(0, 0, 0, 1, -1, 1))
                .withMessageContaining("0.0, 0.0, 0.0 to 1.0, -1.0, 1.0");
        assertThatIllegalArgumentException().isThrownBy(() -> new Box(0, 0, Double.NaN, 1, 1, 1));
    }

    @Test
    void buildingAndAskingAllocateNothingOnceTheyHaveRoom() {
        random = new Random(45);
        scatter(MOST);
        var threads = (ThreadMXBean) ManagementFactory.getThreadMXBean();
        Box box = Box.around(50, 50, 50, 10);
        double[] from = {50, 50, 0};
        double[] to = {55, 55, 20};
        LongPredicate none = key -> false;
        long bytes = 0;
        for (int round = 0; round < 40; round++) {
            scatter(MOST);
            long before = threads.getCurrentThreadAllocatedBytes();
            index.build(ids, lows, highs, rows);
            index.inBox(box, found);
            index.inSphere(50, 50, 50, 20, found);
            index.nearest(50, 50, 50, 20, found);
            index.isOnWay(from, to, 0, none);
            bytes = threads.getCurrentThreadAllocatedBytes() - before;
        }
        assertThat(bytes).as("bytes in the last round").isZero();
    }

    private void scatter(int count) {
        rows = count;
        for (int row = 0; row < rows; row++) {
            double spread = random.nextInt(50) == 0 ? 1e30 : 100;
            double half = random.nextInt(4) == 0 ? 0 : random.nextDouble() * 5;
            put(
                    row,
                    row * 7L + 1,
                    random.nextDouble() * spread,
                    random.nextDouble() * spread,
                    random.nextInt(20),
                    half);
            if (random.nextInt(30) == 0) {
                lows.setAtIndex(ValueLayout.JAVA_DOUBLE, 3L * row + random.nextInt(3), Double.NaN);
            }
        }
    }

    private void move() {
        for (int i = 0; i < 3 * rows; i++) {
            double by = random.nextGaussian();
            lows.setAtIndex(ValueLayout.JAVA_DOUBLE, i, low(i) + by);
            highs.setAtIndex(ValueLayout.JAVA_DOUBLE, i, high(i) + by);
        }
    }

    private void put(int row, long key, double x, double y, double z, double half) {
        double[] at = {x, y, z};
        ids.setAtIndex(ValueLayout.JAVA_LONG, row, key);
        for (int axis = 0; axis < 3; axis++) {
            lows.setAtIndex(ValueLayout.JAVA_DOUBLE, 3L * row + axis, at[axis] - half);
            highs.setAtIndex(ValueLayout.JAVA_DOUBLE, 3L * row + axis, at[axis] + half);
        }
    }

    private void check(String when) {
        double x = random.nextDouble() * 100;
        double y = random.nextDouble() * 100;
        double z = random.nextDouble() * 20;
        double size = random.nextDouble() * 30;
        index.inBox(Box.around(x, y, z, size), found);
        assertThat(keys())
                .as("box, " + when)
                .isEqualTo(
                        where(
                                row -> {
                                    for (int axis = 0; axis < 3; axis++) {
                                        double at = axis == 0 ? x : axis == 1 ? y : z;
                                        if (low(3 * row + axis) > at + size
                                                || high(3 * row + axis) < at - size) {
                                            return false;
                                        }
                                    }
                                    return true;
                                }));
        index.inSphere(x, y, z, size, found);
        assertThat(keys())
                .as("sphere, " + when)
                .isEqualTo(where(row -> squaredDistance(row, x, y, z) <= size * size));
        double[] from = {x, y, z};
        double[] to = {
            random.nextDouble() * 100, random.nextBoolean() ? y : size, random.nextInt(20)
        };
        var onWay = new ArrayList<Long>();
        assertThat(index.isOnWay(from, to, 0, key -> !onWay.add(key))).isFalse();
        onWay.sort(null);
        List<Long> onLine = where(row -> meetsLine(row, from, to));
        assertThat(onWay).as("line, " + when).isEqualTo(onLine);
        for (long key : onLine) {
            assertThat(index.isOnWay(from, to, 0, met -> met == key)).as("stops, " + when).isTrue();
        }
        int most = random.nextInt(20);
        index.nearest(x, y, z, most, found);
        assertThat(keys()).as("nearest %d, %s", most, when).isEqualTo(nearest(x, y, z, most));
    }

    /**
     * Returns whether a line meets the box. Clips the line at one face of the box after the other.
     */
    private boolean meetsLine(int row, double[] from, double[] to) {
        double begin = 0;
        double end = 1;
        for (int axis = 0; axis < 3; axis++) {
            double way = to[axis] - from[axis];
            if (way == 0
                    && (from[axis] < low(3 * row + axis) || from[axis] > high(3 * row + axis))) {
                return false;
            }
            if (way != 0) {
                double enters =
                        ((way > 0 ? low(3 * row + axis) : high(3 * row + axis)) - from[axis]) / way;
                double leaves =
                        ((way > 0 ? high(3 * row + axis) : low(3 * row + axis)) - from[axis]) / way;
                begin = Math.max(begin, enters);
                end = Math.min(end, leaves);
            }
        }
        return begin <= end;
    }

    private List<Long> nearest(double x, double y, double z, int most) {
        record At(double distance, long key) {}
        List<At> all = new ArrayList<>();
        for (int row = 0; row < rows; row++) {
            if (isThere(row)) {
                all.add(new At(squaredDistance(row, x, y, z), key(row)));
            }
        }
        return all.stream()
                .sorted(Comparator.comparingDouble(At::distance).thenComparingLong(At::key))
                .limit(most)
                .map(At::key)
                .toList();
    }

    private List<Long> where(IntPredicate test) {
        List<Long> keys = new ArrayList<>();
        for (int row = 0; row < rows; row++) {
            if (isThere(row) && test.test(row)) {
                keys.add(key(row));
            }
        }
        return keys;
    }

    private double squaredDistance(int row, double x, double y, double z) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
            double at = axis == 0 ? x : axis == 1 ? y : z;
            double away =
                    Math.max(0, Math.max(low(3 * row + axis) - at, at - high(3 * row + axis)));
            sum += away * away;
        }
        return sum;
    }

    private boolean isThere(int row) {
        return !Double.isNaN(low(3 * row) + low(3 * row + 1) + low(3 * row + 2));
    }

    private long key(int row) {
        return ids.getAtIndex(ValueLayout.JAVA_LONG, row);
    }

    private double low(int i) {
        return lows.getAtIndex(ValueLayout.JAVA_DOUBLE, i);
    }

    private double high(int i) {
        return highs.getAtIndex(ValueLayout.JAVA_DOUBLE, i);
    }

    private List<Long> keys() {
        List<Long> keys = new ArrayList<>();
        for (int i = 0; i < found.size(); i++) {
            keys.add(found.key(i));
        }
        return keys;
    }
}
