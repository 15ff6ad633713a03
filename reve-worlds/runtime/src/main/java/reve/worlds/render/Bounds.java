// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

/** A box along the world's axes, from its lowest to its highest corner [m]. */
public record Bounds(Point low, Point high) {

    /** Checks that each coordinate of {@code low} is at most that of {@code high}. */
    public Bounds {
        if (!(low.x() <= high.x() && low.y() <= high.y() && low.z() <= high.z())) {
            throw new IllegalArgumentException(
                    "bounds from " + low + " to " + high + ": expected low <= high on every axis");
        }
    }

    /** Returns the centre of the box [m]. */
    public Point centre() {
        return new Point(
                0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), 0.5 * (low.z() + high.z()));
    }

    /** Returns the length of the longest side [m]. */
    public double longestSide() {
        return Math.max(high.x() - low.x(), Math.max(high.y() - low.y(), high.z() - low.z()));
    }

    /**
     * Returns a corner [m]. Bits 0, 1 and 2 of {@code index} select the high side of x, y and z.
     */
    Point corner(int index) {
        return new Point(
                (index & 1) == 0 ? low.x() : high.x(),
                (index & 2) == 0 ? low.y() : high.y(),
                (index & 4) == 0 ? low.z() : high.z());
    }
}
