// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.space.Box;
import reve.core.space.Found;
import reve.core.space.RelatedBoxes;

import java.util.ArrayList;
import java.util.Comparator;
import java.util.List;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.function.Function;

/**
 * How bodies that have a shape are to each other, by the boxes around them as the last DERIVE left
 * them. Worked out when asked for; who does not ask pays nothing. Same thread as the world or
 * snapshot.
 *
 * <p>What is small is told from the boxes: the size of two bodies is the smaller of their boxes'
 * diagonals, and the tolerance a hundredth of it.
 *
 * <ul>
 *   <li>{@code near}: the gap between the boxes is at most the size
 *   <li>{@code touching}: the gap is at most the tolerance
 *   <li>{@code on}: the bottom of the one is at the top of the other within the tolerance, and seen
 *       from above they overlap
 *   <li>{@code inside}: the one box is within the other, give or take the tolerance, and smaller
 * </ul>
 */
public final class Relations {
    /** All of them. */
    public static final Set<String> NAMES = Set.of("near", "on", "inside", "touching");

    /** Most items that are told for one item and relation. */
    public static final int MAX_ITEMS = RelatedBoxes.MOST;

    private static final double TOLERANCE = RelatedBoxes.TOLERANCE;

    private final TableView bodies;
    private final Space space;
    private final Function<ItemId, String> nameOf;
    private final Found reached = new Found();
    private long compared;

    /**
     * @param nameOf names of items in the table
     */
    Relations(TableView bodies, Space space, Function<ItemId, String> nameOf) {
        this.bodies = bodies;
        this.space = space;
        this.nameOf = nameOf;
    }

    /** Two boxes, seen from the first. The second one is read from one row after another. */
    private static final class Pair {
        private final ColumnView mins;
        private final ColumnView maxs;
        private final double[] low = new double[3];
        private final double[] high = new double[3];
        private final double diagonal;
        private final double[] otherLow = new double[3];
        private final double[] otherHigh = new double[3];
        private double otherDiagonal;

        Pair(TableView bodies, int row) {
            mins = bodies.column("boundsMin");
            maxs = bodies.column("boundsMax");
            read(row, low, high);
            diagonal = diagonal(low, high);
        }

        void with(int row) {
            read(row, otherLow, otherHigh);
            otherDiagonal = diagonal(otherLow, otherHigh);
        }

        private void read(int row, double[] lows, double[] highs) {
            for (int axis = 0; axis < 3; axis++) {
                lows[axis] = mins.getDouble(row, axis);
                highs[axis] = maxs.getDouble(row, axis);
            }
        }

        double size() {
            return Math.min(diagonal, otherDiagonal);
        }

        double gap() {
            double sum = 0;
            for (int axis = 0; axis < 3; axis++) {
                double along =
                        Math.max(
                                0,
                                Math.max(otherLow[axis] - high[axis], low[axis] - otherHigh[axis]));
                sum += along * along;
            }
            return Math.sqrt(sum);
        }

        boolean isOn() {
            return Math.abs(low[1] - otherHigh[1]) <= TOLERANCE * size()
                    && overlaps(0)
                    && overlaps(2);
        }

        boolean isInside() {
            boolean within = diagonal < otherDiagonal;
            for (int axis = 0; axis < 3; axis++) {
                within &=
                        low[axis] >= otherLow[axis] - TOLERANCE * size()
                                && high[axis] <= otherHigh[axis] + TOLERANCE * size();
            }
            return within;
        }

        boolean holds(String relation) {
            return switch (relation) {
                case "near" -> gap() <= size();
                case "touching" -> gap() <= TOLERANCE * size();
                case "on" -> isOn();
                default -> isInside();
            };
        }

        /** A box that everything meets to which the relation may hold. */
        Box reach(String relation) {
            double by = diagonal * (relation.equals("near") ? 1 : TOLERANCE);
            return new Box(
                    low[0] - by,
                    low[1] - by,
                    low[2] - by,
                    high[0] + by,
                    high[1] + by,
                    high[2] + by);
        }

        private boolean overlaps(int axis) {
            return Math.min(high[axis], otherHigh[axis]) > Math.max(low[axis], otherLow[axis]);
        }
    }

    /** One of the others, and how far away it is [m]. */
    private record Other(ItemId id, double gap) {}

    private static final Comparator<Other> NEAREST =
            Comparator.comparingDouble(Other::gap).thenComparing(Other::id);

    /**
     * Names of the items that an item is near, on, inside or touching: the smallest gap first, then
     * in the order of their ids, at most {@link #MAX_ITEMS}.
     *
     * @param relation one of {@link #NAMES}
     * @throws IllegalArgumentException for any other relation
     * @return empty if the item is no body with a shape
     */
    public Optional<List<String>> of(ItemId item, String relation) {
        if (!NAMES.contains(relation)) {
            throw new IllegalArgumentException(
                    "relation " + relation + ", expected one of " + new TreeSet<>(NAMES));
        }
        ColumnView shapes = bodies.column("shape");
        int row = bodies.rowOf(item);
        if (row < 0 || shapes.getInt(row, 0) == Shape.NONE) {
            return Optional.empty();
        }
        var pair = new Pair(bodies, row);
        List<Other> others = new ArrayList<>();
        int meeting = 0;
        space.inBox(pair.reach(relation), reached);
        compared += reached.size();
        for (int i = 0; i < reached.size(); i++) {
            var id = new ItemId(reached.key(i));
            int other = bodies.rowOf(id);
            if (other >= 0 && other != row && shapes.getInt(other, 0) != Shape.NONE) {
                pair.with(other);
                if (pair.holds(relation)) {
                    double gap = pair.gap();
                    others.add(new Other(id, gap));
                    if (gap == 0 && ++meeting == MAX_ITEMS) {
                        break; // those that follow have higher ids and no smaller gap
                    }
                }
            }
        }
        others.sort(NEAREST);
        return Optional.of(others.stream().limit(MAX_ITEMS).map(Other::id).map(nameOf).toList());
    }

    /**
     * Returns how many bodies were found within reach for all answers so far, which is what answers
     * cost. The same number on every machine.
     */
    public long compared() {
        return compared;
    }

    private static double diagonal(double[] low, double[] high) {
        double x = high[0] - low[0];
        double y = high[1] - low[1];
        double z = high[2] - low[2];
        return Math.sqrt(x * x + y * y + z * z);
    }
}
