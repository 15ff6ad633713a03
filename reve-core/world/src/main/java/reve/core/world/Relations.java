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
 * Spatial relations between bodies that have a shape. They are computed when they are read, from
 * the bounding boxes of the last DERIVE phase. For the thread that owns the world or uses the
 * snapshot.
 *
 * <p>The definitions use the <i>size</i>, which is the smaller one of the two boxes' diagonals. The
 * tolerance is a hundredth of this size.
 *
 * <ul>
 *   <li>{@code near}: the gap between the boxes is at most the size
 *   <li>{@code touching}: the gap is at most the tolerance
 *   <li>{@code on}: the bottom of the first box is at the top of the second within the tolerance,
 *       and they overlap as seen from above
 *   <li>{@code inside}: the first box is within the second, up to the tolerance, and has the
 *       smaller diagonal
 * </ul>
 */
public final class Relations {
    /** Names of all relations. */
    public static final Set<String> NAMES = Set.of("near", "on", "inside", "touching");

    /** Maximum number of related items per item and relation. */
    public static final int MAX_ITEMS = RelatedBoxes.MOST;

    private static final double TOLERANCE = RelatedBoxes.TOLERANCE;

    private final TableView bodies;
    private final Space space;
    private final Function<ItemId, String> nameOf;
    private final Found reached = new Found();
    private long compared;

    /**
     * @param nameOf returns the name of an item in the table
     */
    Relations(TableView bodies, Space space, Function<ItemId, String> nameOf) {
        this.bodies = bodies;
        this.space = space;
        this.nameOf = nameOf;
    }

    /**
     * The box of the item for which relations are computed, and the box of another body. The second
     * box is replaced for each other body, so that one object serves all of them.
     */
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

        /**
         * Returns a box that intersects the boxes of all bodies to which the relation may apply.
         */
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

    /** A related item, and the gap between the boxes [m]. */
    private record Other(ItemId id, double gap) {}

    private static final Comparator<Other> NEAREST =
            Comparator.comparingDouble(Other::gap).thenComparing(Other::id);

    /**
     * Returns the names of the items to which an item has a relation, ordered by gap, then by id.
     * Returns at most {@link #MAX_ITEMS} names.
     *
     * @param relation one of {@link #NAMES}
     * @throws IllegalArgumentException for any other relation
     * @return empty if the item is not a body with a shape
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
                        break; // all later items have higher ids and no smaller gap
                    }
                }
            }
        }
        others.sort(NEAREST);
        return Optional.of(others.stream().limit(MAX_ITEMS).map(Other::id).map(nameOf).toList());
    }

    /**
     * Returns the number of bodies compared for all answers so far, as a measure of their cost. The
     * number is the same on every machine.
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
