// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import java.lang.foreign.MemorySegment;
import java.lang.foreign.ValueLayout;
import java.util.function.LongPredicate;

/**
 * An index that finds the boxes that meet a region or are nearest to a point. It is a packed tree
 * of boxes (an R-tree whose nodes contain eight neighbours along a space-filling curve). Whenever
 * boxes move, the caller loads all boxes again. Results depend only on the boxes, not on earlier
 * loads, and have a fixed order. For one thread.
 *
 * <p>A load with the same number of boxes reuses their order along the curve and computes only the
 * nodes. The load sorts the boxes again if they have moved far since they were sorted.
 */
public final class BoxIndex {

    static final int FAN_OUT = 8;
    private static final int AXES = 3;
    private static final int SIDES = 2 * AXES;
    static final int MAX_LEVELS = 12;
    private static final int NOTHING = -1;

    /**
     * Factor by which the edges of a leaf node must have grown for the node to count as worn. The
     * boxes are sorted again if many nodes are worn.
     */
    private static final double WORN_OUT = 2;

    /** Bound on the relative error of a distance along a ray. */
    private static final double ROUNDING = 1e-9;

    private final RankedOrder ranked = new RankedOrder();
    private final Queue queue = new Queue();
    private final int[] stack = new int[FAN_OUT * MAX_LEVELS];

    /** Distance at which a ray enters each node of the stack, see {@link #nearestOnRay}. */
    private final double[] entries = new double[FAN_OUT * MAX_LEVELS];

    private double[] lows = {};
    private double[] highs = {};
    private long[] givenKeys = {};
    private int[] centres = {};
    private int[] order = {};
    private int ordered = NOTHING;

    /**
     * Sum of the three edges of each leaf node [m], at the time when the boxes were last sorted.
     */
    private double[] extents = {};

    /**
     * (nodes x 6) lower and upper corners of the nodes. The first nodes are the boxes in their
     * order along the curve. Each node of the next level encloses eight nodes of the level below
     * it.
     */
    private double[] sides = {};

    private long[] keys = {};

    /** Index of the first node of each level. The last element is the index after the last node. */
    private final int[] firstOf = new int[MAX_LEVELS + 2];

    private int levels;
    private long visited;

    /**
     * Replaces the boxes. Allocates memory only if there are more boxes than in all earlier calls.
     *
     * @param ids (rows) keys of the boxes, distinct longs
     * @param lows (rows x 3) lower corners in doubles; a box with a NaN is ignored
     * @param highs (rows x 3) upper corners
     */
    public void build(MemorySegment ids, MemorySegment lows, MemorySegment highs, int rows) {
        reserve(rows);
        int count = read(ids, lows, highs, rows);
        if (count == ordered) {
            fill(count);
        }
        if (count != ordered || isWorn()) {
            putInOrder(count);
            fill(count);
            rememberExtents();
        }
    }

    /**
     * Returns the number of boxes and nodes that all calls of {@link #isOnWay} have examined. The
     * number depends on the boxes and the calls only, so it may limit work in the same way on every
     * machine.
     */
    public long visited() {
        return visited;
    }

    /** Returns the number of boxes. */
    public int size() {
        return firstOf[1];
    }

    /** Finds the keys of all boxes that meet or touch a box, in ascending order. */
    public void inBox(Box box, Found found) {
        found.clear();
        int depth = pushTop();
        while (depth > 0) {
            int node = stack[--depth];
            int at = SIDES * node;
            if (sides[at] <= box.maxX()
                    && sides[at + 3] >= box.minX()
                    && sides[at + 1] <= box.maxY()
                    && sides[at + 4] >= box.minY()
                    && sides[at + 2] <= box.maxZ()
                    && sides[at + 5] >= box.minZ()) {
                depth = enter(node, depth, found);
            }
        }
        found.sort();
    }

    /** Finds the keys of all boxes that meet or touch a ball, in ascending order. */
    public void inSphere(double x, double y, double z, double radius, Found found) {
        found.clear();
        int depth = pushTop();
        while (depth > 0) {
            int node = stack[--depth];
            if (squaredDistance(node, x, y, z) <= radius * radius) {
                depth = enter(node, depth, found);
            }
        }
        found.sort();
    }

    /**
     * Returns whether the segment between two points meets or touches a box for which {@code
     * counts} returns true.
     *
     * @param ends fraction of the segment that is ignored at each end, for example 1e-9
     * @param counts called with the keys of the boxes on the segment, in no particular order, until
     *     the call returns true
     */
    public boolean isOnWay(double[] from, double[] to, double ends, LongPredicate counts) {
        int depth = pushTop();
        while (depth > 0) {
            int node = stack[--depth];
            visited++;
            if (isOnLine(node, from, to, ends)) {
                if (node >= size()) {
                    depth = pushChildren(node, depth);
                } else if (counts.test(keys[node])) {
                    return true;
                }
            }
        }
        return false;
    }

    /**
     * Returns whether the segment meets a node. The slab method tests whether the segment's
     * intervals between the three pairs of opposite faces overlap. Rounding is monotonic, so a
     * segment that meets a box also meets the nodes around the box.
     */
    private boolean isOnLine(int node, double[] from, double[] to, double ends) {
        int at = SIDES * node;
        double enter = ends;
        double leave = 1 - ends;
        for (int axis = 0; axis < AXES; axis++) {
            double way = to[axis] - from[axis];
            double low = sides[at + axis];
            double high = sides[at + AXES + axis];
            if (way == 0) {
                if (from[axis] < low || from[axis] > high) {
                    return false;
                }
            } else {
                double a = (low - from[axis]) / way;
                double b = (high - from[axis]) / way;
                enter = Math.max(enter, Math.min(a, b));
                leave = Math.min(leave, Math.max(a, b));
            }
        }
        return enter <= leave;
    }

    /** A function that computes the exact distance along a ray to the content of a box. */
    public interface RayTest {
        /**
         * Returns the distance to the content of a box.
         *
         * @param most distance above which the result does not matter [m]
         * @return the distance [m], infinite if the ray does not meet the content
         */
        double distance(long key, double most);
    }

    /**
     * Returns the least distance along a ray to the contents of the boxes [m]. The result does not
     * depend on the order of the boxes.
     *
     * @param direction of length 1
     * @param most greatest distance [m]
     * @param test called for boxes that the ray meets, in no particular order
     * @param effort limit on the search; {@code test} may use it for searches of its own
     * @return infinite if the ray meets nothing up to the greatest distance, or if the effort is
     *     exhausted
     */
    public double nearestOnRay(
            double[] from, double[] direction, double most, RayTest test, Effort effort) {
        double nearest = Double.POSITIVE_INFINITY;
        double limit = most;
        int depth = pushTop();
        if (depth > 0) {
            entries[0] = entry(stack[0], from, direction, limit);
        }
        while (depth > 0) {
            if (!effort.spend(1)) {
                return Double.POSITIVE_INFINITY;
            }
            int node = stack[--depth];
            if (entries[depth] > limit + ROUNDING * (1 + limit)) {
                continue;
            }
            if (node >= size()) {
                depth = pushNearestLast(node, depth, from, direction, limit);
            } else {
                double distance = test.distance(keys[node], limit);
                if (distance <= limit) {
                    nearest = distance;
                    limit = distance;
                }
            }
        }
        return nearest;
    }

    /**
     * Pushes the children of a node that a ray meets on the stack. The nearest child is pushed
     * last, so that the search visits it first. Returns the new depth of the stack.
     */
    private int pushNearestLast(
            int node, int depth, double[] from, double[] direction, double most) {
        int level = levelOf(node);
        int first = firstChild(node, level);
        int after = depth;
        for (int child = first; child < lastChild(first, level); child++) {
            double entry = entry(child, from, direction, most);
            if (entry < Double.POSITIVE_INFINITY) {
                int at = after++;
                for (; at > depth && entries[at - 1] < entry; at--) {
                    stack[at] = stack[at - 1];
                    entries[at] = entries[at - 1];
                }
                stack[at] = child;
                entries[at] = entry;
            }
        }
        return after;
    }

    /**
     * Returns the distance at which a ray enters a node, by the slab method; infinite if the ray
     * does not meet the node up to the distance {@code most}. Rounding errors never hide a box
     * whose content the ray meets.
     */
    private double entry(int node, double[] from, double[] direction, double most) {
        int at = SIDES * node;
        double enter = 0;
        double leave = most;
        for (int axis = 0; axis < AXES; axis++) {
            double low = sides[at + axis];
            double high = sides[at + AXES + axis];
            if (direction[axis] == 0) {
                double error = ROUNDING * (Math.abs(low) + Math.abs(high));
                if (from[axis] < low - error || from[axis] > high + error) {
                    return Double.POSITIVE_INFINITY;
                }
            } else {
                double a = (low - from[axis]) / direction[axis];
                double b = (high - from[axis]) / direction[axis];
                enter = Math.max(enter, Math.min(a, b));
                leave = Math.min(leave, Math.max(a, b));
            }
        }
        return enter <= leave + ROUNDING * (1 + Math.abs(leave)) ? enter : Double.POSITIVE_INFINITY;
    }

    /**
     * Finds the keys of the boxes nearest to a point. They are ordered by the distance from the
     * point to the box (0 inside it), then by key.
     *
     * @param most maximum number of results
     */
    public void nearest(double x, double y, double z, int most, Found found) {
        found.clear();
        queue.clear();
        if (size() > 0) {
            queue.add(0, Queue.NODE, firstOf[levels + 1] - 1);
        }
        while (found.size() < most && !queue.isEmpty()) {
            int node = queue.node();
            queue.remove();
            if (node < size()) {
                found.add(keys[node]);
                continue;
            }
            int level = levelOf(node);
            int first = firstChild(node, level);
            for (int child = first; child < lastChild(first, level); child++) {
                long key = child < size() ? keys[child] : Queue.NODE;
                queue.add(squaredDistance(child, x, y, z), key, child);
            }
        }
    }

    private int pushTop() {
        stack[0] = firstOf[levels + 1] - 1;
        return size() > 0 ? 1 : 0;
    }

    /**
     * Adds a box to the results, or pushes the children of a node on the stack. Returns the new
     * depth of the stack.
     */
    private int enter(int node, int depth, Found found) {
        if (node < size()) {
            found.add(keys[node]);
            return depth;
        }
        return pushChildren(node, depth);
    }

    private int pushChildren(int node, int depth) {
        int level = levelOf(node);
        int first = firstChild(node, level);
        int after = depth;
        for (int child = first; child < lastChild(first, level); child++) {
            stack[after++] = child;
        }
        return after;
    }

    // ---- methods for searches of this package ---- Nodes with an index below size() are the
    // boxes, and the last node is the root.

    /** Returns the number of nodes, including boxes. */
    int nodes() {
        return size() == 0 ? 0 : firstOf[levels + 1];
    }

    /** Returns the (nodes x 6) lower and upper corners. The array belongs to this index. */
    double[] sides() {
        return sides;
    }

    /** Returns the key of a box. */
    long key(int box) {
        return keys[box];
    }

    int firstChild(int node) {
        return firstChild(node, levelOf(node));
    }

    /** Returns the index after the last child of a node. */
    int endOfChildren(int node) {
        int level = levelOf(node);
        return lastChild(firstChild(node, level), level);
    }

    private int levelOf(int node) {
        int level = levels;
        while (firstOf[level] > node) {
            level--;
        }
        return level;
    }

    private int firstChild(int node, int level) {
        return firstOf[level - 1] + FAN_OUT * (node - firstOf[level]);
    }

    private int lastChild(int first, int level) {
        return Math.min(first + FAN_OUT, firstOf[level]);
    }

    /** Returns the squared distance from a point to a node [m²]; 0 inside it. */
    double squaredDistance(int node, double x, double y, double z) {
        int at = SIDES * node;
        double dx = Math.max(0, Math.max(sides[at] - x, x - sides[at + 3]));
        double dy = Math.max(0, Math.max(sides[at + 1] - y, y - sides[at + 4]));
        double dz = Math.max(0, Math.max(sides[at + 2] - z, z - sides[at + 5]));
        return dx * dx + dy * dy + dz * dz;
    }

    /**
     * Copies the boxes, except those with a NaN, into arrays. Returns the number of copied boxes.
     */
    private int read(
            MemorySegment ids, MemorySegment givenLows, MemorySegment givenHighs, int rows) {
        MemorySegment.copy(ids, ValueLayout.JAVA_LONG, 0, givenKeys, 0, rows);
        MemorySegment.copy(givenLows, ValueLayout.JAVA_DOUBLE, 0, lows, 0, AXES * rows);
        MemorySegment.copy(givenHighs, ValueLayout.JAVA_DOUBLE, 0, highs, 0, AXES * rows);
        int count = 0;
        for (int row = 0; row < rows; row++) {
            int at = AXES * row;
            if (lows[at] <= highs[at]
                    && lows[at + 1] <= highs[at + 1]
                    && lows[at + 2] <= highs[at + 2]) {
                if (count < row) {
                    System.arraycopy(lows, at, lows, AXES * count, AXES);
                    System.arraycopy(highs, at, highs, AXES * count, AXES);
                    givenKeys[count] = givenKeys[row];
                }
                count++;
            }
        }
        return count;
    }

    private void putInOrder(int count) {
        for (int i = 0; i < AXES * count; i++) {
            centres[i] = RankedOrder.sortable(0.5 * lows[i] + 0.5 * highs[i]);
        }
        order = ranked.sort(centres, count);
        ordered = count;
    }

    /** Returns true if so many leaf nodes are worn that the boxes must be sorted again. */
    private boolean isWorn() {
        int grown = 0;
        for (int node = size(); node < firstOf[2]; node++) {
            grown += extent(node) > WORN_OUT * extents[node - size()] ? 1 : 0;
        }
        return grown * FAN_OUT > firstOf[2] - size();
    }

    private void rememberExtents() {
        for (int node = size(); node < firstOf[2]; node++) {
            extents[node - size()] = extent(node);
        }
    }

    private double extent(int node) {
        int at = SIDES * node;
        return sides[at + 3]
                - sides[at]
                + (sides[at + 4] - sides[at + 1])
                + (sides[at + 5] - sides[at + 2]);
    }

    /**
     * Writes the boxes in their order along the curve, then computes the higher levels of nodes.
     */
    private void fill(int count) {
        for (int i = 0; i < count; i++) {
            keys[i] = givenKeys[order[i]];
            for (int axis = 0; axis < AXES; axis++) {
                sides[SIDES * i + axis] = lows[AXES * order[i] + axis];
                sides[SIDES * i + AXES + axis] = highs[AXES * order[i] + axis];
            }
        }
        buildLevels(count);
    }

    private void buildLevels(int count) {
        levels = 0;
        firstOf[0] = 0;
        firstOf[1] = count;
        firstOf[2] = count;
        while (firstOf[levels + 1] - firstOf[levels] > 1) {
            int end = firstOf[levels + 1];
            int node = end;
            for (int first = firstOf[levels]; first < end; first += FAN_OUT) {
                enclose(first, Math.min(first + FAN_OUT, end), node++);
            }
            levels++;
            firstOf[levels + 1] = node;
        }
    }

    private void enclose(int first, int end, int node) {
        int at = SIDES * node;
        System.arraycopy(sides, SIDES * first, sides, at, SIDES);
        for (int child = first + 1; child < end; child++) {
            for (int axis = 0; axis < AXES; axis++) {
                sides[at + axis] = Math.min(sides[at + axis], sides[SIDES * child + axis]);
                sides[at + AXES + axis] =
                        Math.max(sides[at + AXES + axis], sides[SIDES * child + AXES + axis]);
            }
        }
    }

    private void reserve(int rows) {
        if (givenKeys.length >= rows) {
            return;
        }
        int room = Math.max(rows, 2 * givenKeys.length);
        lows = new double[AXES * room];
        highs = new double[AXES * room];
        givenKeys = new long[room];
        centres = new int[AXES * room];
        extents = new double[room / FAN_OUT + 1];
        keys = new long[room];
        ordered = NOTHING;
        // Each level has an eighth of the nodes of the level below it, rounded up.
        sides = new double[SIDES * (room + room / (FAN_OUT - 1) + MAX_LEVELS)];
    }
}
