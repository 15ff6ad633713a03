// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.lang.foreign.MemorySegment;
import java.util.Arrays;
import java.util.stream.LongStream;

/**
 * Search for the boxes to which a box has the relations near, on, inside and touching. {@code
 * Relations} defines these relations. One descent through a {@link BoxIndex} finds all four. The
 * search skips a subtree as soon as the subtree cannot contain a result. It uses plain arrays and
 * allocates no memory. For one thread.
 */
public final class RelatedBoxes {

    /** Index of the relation "inside". The relations are in alphabetical order. */
    public static final int INSIDE = 0;

    /** Index of the relation "near". */
    public static final int NEAR = 1;

    /** Index of the relation "on". */
    public static final int ON = 2;

    /** Index of the relation "touching". */
    public static final int TOUCHING = 3;

    /** Number of relations. */
    public static final int RELATIONS = 4;

    /** Maximum number of results for one box and relation. */
    public static final int MOST = 32;

    /** Distance that counts as zero, as a fraction of the smaller diagonal of two boxes. */
    public static final double TOLERANCE = 0.01;

    private static final int AXES = 3;
    private static final int SIDES = 2 * AXES;
    private static final int DEEPEST = 128;

    private final BoxIndex index = new BoxIndex();
    private double[] lows = {};
    private double[] highs = {};
    private int count;

    // This array and the next ones contain one element per node of the tree.
    private long[] firstBox = {};
    private double[] diagonal = {};
    private double[] lowestTop = {};

    // Stack of the nodes to visit. Each entry has three parts: the node, a bit set of the relations
    // that its boxes may have, and the distance from the box.
    private final int[] stack = new int[DEEPEST];
    private final int[] mayHold = new int[DEEPEST];
    private final double[] gaps = new double[DEEPEST];
    private int depth;

    // The box whose related boxes are searched.
    private final double[] low = new double[AXES];
    private final double[] high = new double[AXES];
    private final double[] closeLow = new double[AXES];
    private final double[] closeHigh = new double[AXES];
    private final double[] farLow = new double[AXES];
    private final double[] farHigh = new double[AXES];
    private int box;
    private double size;

    // Results by relation: their number, the found boxes (nearest first) and the distances of these
    // boxes.
    private final int[] found = new int[RELATIONS];
    private final int[][] boxes = new int[RELATIONS][MOST];
    private final double[][] distances = new double[RELATIONS][MOST];

    /**
     * Replaces the boxes. Among results at equal distance, the box with the lower index comes
     * first.
     *
     * @param newLows (count x 3) lower corners [m]
     * @param newHighs (count x 3) upper corners [m]
     * @return false if they are equal to the present boxes
     */
    public boolean load(double[] newLows, double[] newHighs, int newCount) {
        int numbers = AXES * newCount;
        if (newCount == count
                && Arrays.equals(lows, 0, numbers, newLows, 0, numbers)
                && Arrays.equals(highs, 0, numbers, newHighs, 0, numbers)) {
            return false;
        }
        count = newCount;
        lows = Arrays.copyOf(newLows, numbers);
        highs = Arrays.copyOf(newHighs, numbers);
        index.build(
                MemorySegment.ofArray(LongStream.range(0, count).toArray()),
                MemorySegment.ofArray(lows),
                MemorySegment.ofArray(highs),
                count);
        describeNodes();
        return true;
    }

    private void describeNodes() {
        int nodes = index.nodes();
        if (firstBox.length < nodes) {
            firstBox = new long[nodes];
            diagonal = new double[nodes];
            lowestTop = new double[nodes];
        }
        double[] sides = index.sides();
        for (int node = 0; node < nodes; node++) {
            int at = SIDES * node;
            if (node < index.size()) {
                firstBox[node] = index.key(node);
                diagonal[node] =
                        diagonal(
                                sides[at + 3] - sides[at],
                                sides[at + 4] - sides[at + 1],
                                sides[at + 5] - sides[at + 2]);
                lowestTop[node] = sides[at + 4];
                continue;
            }
            int first = index.firstChild(node);
            int end = index.endOfChildren(node);
            firstBox[node] = firstBox[first];
            diagonal[node] = diagonal[first];
            lowestTop[node] = lowestTop[first];
            for (int child = first + 1; child < end; child++) {
                firstBox[node] = Math.min(firstBox[node], firstBox[child]);
                diagonal[node] = Math.max(diagonal[node], diagonal[child]);
                lowestTop[node] = Math.min(lowestTop[node], lowestTop[child]);
            }
        }
    }

    private static double diagonal(double x, double y, double z) {
        return Math.sqrt(x * x + y * y + z * z);
    }

    /** Returns the number of boxes. */
    public int size() {
        return count;
    }

    /** Finds the boxes to which a box has each relation. */
    public void find(int ofBox) {
        take(ofBox);
        depth = 0;
        if (index.size() > 0) {
            push(index.nodes() - 1);
        }
        while (depth > 0) {
            depth--;
            int node = stack[depth];
            double gap = gaps[depth];
            int wanted = withoutFull(mayHold[depth], gap, firstBox[node]);
            if (wanted != 0) {
                if (node < index.size()) {
                    test(node, gap, wanted);
                } else {
                    pushChildren(node);
                }
            }
        }
    }

    /** Returns the number of boxes that {@link #find} found for a relation. */
    public int found(int relation) {
        return found[relation];
    }

    /**
     * Returns the index of a found box.
     *
     * @param place place in the order of gaps, from 0 for the smallest gap; equal gaps are ordered
     *     by index
     */
    public int found(int relation, int place) {
        return boxes[relation][place];
    }

    private void take(int ofBox) {
        box = ofBox;
        System.arraycopy(lows, AXES * box, low, 0, AXES);
        System.arraycopy(highs, AXES * box, high, 0, AXES);
        size = diagonal(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
        double close = size * TOLERANCE;
        for (int axis = 0; axis < AXES; axis++) {
            closeLow[axis] = low[axis] - close;
            closeHigh[axis] = high[axis] + close;
            farLow[axis] = low[axis] - size;
            farHigh[axis] = high[axis] + size;
        }
        Arrays.fill(found, 0);
    }

    /** Pushes a node on the stack if it may contain a result. */
    private void push(int node) {
        if (!meets(node, farLow, farHigh)) {
            return;
        }
        double gap = gap(node);
        int may = gap <= size ? 1 << NEAR : 0;
        if (meets(node, closeLow, closeHigh)) {
            may |= gap <= TOLERANCE * size ? 1 << TOUCHING : 0;
            may |= mayBeUnder(node) ? 1 << ON : 0;
            may |= diagonal[node] > size && mayHoldIt(node) ? 1 << INSIDE : 0;
        }
        may = withoutFull(may, gap, firstBox[node]);
        if (may != 0) {
            stack[depth] = node;
            mayHold[depth] = may;
            gaps[depth++] = gap;
        }
    }

    /**
     * Pushes the children of a node on the stack. The nearest child is pushed last, so it is
     * visited first.
     */
    private void pushChildren(int node) {
        int bottom = depth;
        int first = index.firstChild(node);
        int end = index.endOfChildren(node);
        for (int child = end - 1; child >= first; child--) {
            int before = depth;
            push(child);
            if (depth > before) {
                sink(bottom);
            }
        }
    }

    private void sink(int bottom) {
        for (int at = depth - 1;
                at > bottom
                        && isBefore(
                                gaps[at - 1],
                                firstBox[stack[at - 1]],
                                gaps[at],
                                firstBox[stack[at]]);
                at--) {
            int node = stack[at];
            int may = mayHold[at];
            double gap = gaps[at];
            stack[at] = stack[at - 1];
            mayHold[at] = mayHold[at - 1];
            gaps[at] = gaps[at - 1];
            stack[at - 1] = node;
            mayHold[at - 1] = may;
            gaps[at - 1] = gap;
        }
    }

    /**
     * Returns the relations to which boxes of a node may still add results. Omits a relation if it
     * has {@link #MOST} results that all precede every box of the node.
     */
    private int withoutFull(int relations, double gap, long first) {
        int left = relations;
        for (int relation = 0; relation < RELATIONS; relation++) {
            if (found[relation] == MOST
                    && !isBefore(
                            gap, first, distances[relation][MOST - 1], boxes[relation][MOST - 1])) {
                left &= ~(1 << relation);
            }
        }
        return left;
    }

    private static boolean isBefore(double gap, long first, double otherGap, long otherFirst) {
        return gap < otherGap || gap == otherGap && first < otherFirst;
    }

    /** Adds a box to the results of each wanted relation that the exact test confirms. */
    private void test(int leaf, double gap, int wanted) {
        int other = (int) firstBox[leaf];
        if (other == box) {
            return;
        }
        double both = Math.min(size, diagonal[leaf]);
        if ((wanted & 1 << NEAR) != 0 && gap <= both) {
            add(NEAR, gap, other);
        }
        if ((wanted & 1 << TOUCHING) != 0 && gap <= TOLERANCE * both) {
            add(TOUCHING, gap, other);
        }
        if ((wanted & 1 << ON) != 0 && Math.abs(low[1] - lowestTop[leaf]) <= TOLERANCE * both) {
            add(ON, gap, other);
        }
        if ((wanted & 1 << INSIDE) != 0) {
            add(INSIDE, gap, other);
        }
    }

    private void add(int relation, double gap, int other) {
        int[] others = boxes[relation];
        double[] ranked = distances[relation];
        int at = Math.min(found[relation], MOST - 1);
        found[relation] = at + 1;
        while (at > 0 && isBefore(gap, other, ranked[at - 1], others[at - 1])) {
            ranked[at] = ranked[at - 1];
            others[at] = others[at - 1];
            at--;
        }
        ranked[at] = gap;
        others[at] = other;
    }

    // The tests below are used for nodes and for boxes. A node's bounds contain the bounds of its
    // boxes, and rounding is monotonic. Therefore a condition that is true for a box is also true
    // for the nodes around the box.

    private boolean meets(int node, double[] fromLow, double[] toHigh) {
        double[] sides = index.sides();
        int at = SIDES * node;
        return sides[at] <= toHigh[0]
                && sides[at + 3] >= fromLow[0]
                && sides[at + 1] <= toHigh[1]
                && sides[at + 4] >= fromLow[1]
                && sides[at + 2] <= toHigh[2]
                && sides[at + 5] >= fromLow[2];
    }

    private double gap(int node) {
        double[] sides = index.sides();
        int at = SIDES * node;
        double x = Math.max(0, Math.max(sides[at] - high[0], low[0] - sides[at + 3]));
        double y = Math.max(0, Math.max(sides[at + 1] - high[1], low[1] - sides[at + 4]));
        double z = Math.max(0, Math.max(sides[at + 2] - high[2], low[2] - sides[at + 5]));
        double sum = x * x + y * y + z * z;
        return sum == 0 ? 0 : Math.sqrt(sum);
    }

    private boolean mayBeUnder(int node) {
        double tolerance = TOLERANCE * size;
        return low[1] - index.sides()[SIDES * node + 4] <= tolerance
                && lowestTop[node] - low[1] <= tolerance
                && overlaps(node, 0)
                && overlaps(node, 2);
    }

    private boolean overlaps(int node, int axis) {
        double[] sides = index.sides();
        int at = SIDES * node + axis;
        return Math.min(high[axis], sides[at + AXES]) > Math.max(low[axis], sides[at]);
    }

    private boolean mayHoldIt(int node) {
        double[] sides = index.sides();
        int at = SIDES * node;
        double tolerance = TOLERANCE * size;
        boolean holds = true;
        for (int axis = 0; axis < AXES; axis++) {
            holds &=
                    low[axis] >= sides[at + axis] - tolerance
                            && high[axis] <= sides[at + AXES + axis] + tolerance;
        }
        return holds;
    }
}
