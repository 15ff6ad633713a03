// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

/**
 * A walk through the nodes of a {@link BoxIndex}, from near to far. The caller decides for each
 * node whether the walk enters it. The walk may pause for as long as the boxes of the index do not
 * change. For one thread.
 *
 * <p>The children of a node follow each other by their distance, but the nodes of different parents
 * may alternate. A caller must therefore not rely on the order.
 */
public final class BoxWalk {

    private static final int AXES = 3;
    private static final int SIDES = 2 * AXES;

    private final int[] stack = new int[BoxIndex.FAN_OUT * BoxIndex.MAX_LEVELS];

    /** Squared distance from the origin of the walk to each node of the stack [m²]. */
    private final double[] squares = new double[BoxIndex.FAN_OUT * BoxIndex.MAX_LEVELS];

    private final double[] origin = new double[AXES];
    private int depth;
    private int node;
    private double square;
    private double centreX;
    private double centreY;
    private double centreZ;
    private double radius;

    /**
     * Begins a walk at the root.
     *
     * @param from (3) the point from which the walk measures distances [m]
     */
    public void begin(BoxIndex index, double[] from) {
        System.arraycopy(from, 0, origin, 0, AXES);
        depth = index.size() > 0 ? 1 : 0;
        if (depth > 0) {
            stack[0] = index.nodes() - 1;
            squares[0] = index.squaredDistance(stack[0], origin[0], origin[1], origin[2]);
        }
    }

    /** Moves to the next node. Returns false if there is none. */
    public boolean next(BoxIndex index) {
        if (depth == 0) {
            return false;
        }
        node = stack[--depth];
        square = squares[depth];
        double[] sides = index.sides();
        int at = SIDES * node;
        double x = 0.5 * sides[at + 3] - 0.5 * sides[at];
        double y = 0.5 * sides[at + 4] - 0.5 * sides[at + 1];
        double z = 0.5 * sides[at + 5] - 0.5 * sides[at + 2];
        centreX = 0.5 * sides[at] + 0.5 * sides[at + 3];
        centreY = 0.5 * sides[at + 1] + 0.5 * sides[at + 4];
        centreZ = 0.5 * sides[at + 2] + 0.5 * sides[at + 5];
        radius = Math.sqrt(x * x + y * y + z * z);
        return true;
    }

    /** Adds the children of the current node, which is no box, to the nodes that follow. */
    public void enter(BoxIndex index) {
        int base = depth;
        int end = index.endOfChildren(node);
        for (int child = index.firstChild(node); child < end; child++) {
            double far = index.squaredDistance(child, origin[0], origin[1], origin[2]);
            int at = depth++;
            for (; at > base && squares[at - 1] < far; at--) {
                stack[at] = stack[at - 1];
                squares[at] = squares[at - 1];
            }
            stack[at] = child;
            squares[at] = far;
        }
    }

    /** Returns whether the current node is a box, not a node around boxes. */
    public boolean isBox(BoxIndex index) {
        return node < index.size();
    }

    /** Returns the key of the current node, which is a box. */
    public long key(BoxIndex index) {
        return index.key(node);
    }

    /** Returns the distance from the origin of the walk to the current node [m]; 0 inside it. */
    public double distance() {
        return Math.sqrt(square);
    }

    /** Returns the x coordinate of the centre of the current node [m]. */
    public double centreX() {
        return centreX;
    }

    /** Returns the y coordinate of the centre of the current node [m]. */
    public double centreY() {
        return centreY;
    }

    /** Returns the z coordinate of the centre of the current node [m]. */
    public double centreZ() {
        return centreZ;
    }

    /** Returns the radius of the ball around the current node [m]. */
    public double radius() {
        return radius;
    }
}
