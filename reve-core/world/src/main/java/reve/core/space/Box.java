// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

/** An axis-aligned box, including its faces [m]. Its sides may be infinite. */
public record Box(double minX, double minY, double minZ, double maxX, double maxY, double maxZ) {

    /**
     * Checks the corners.
     *
     * @throws IllegalArgumentException if a number is NaN, or a lower coordinate is above the upper
     *     one
     */
    public Box {
        if (!(minX <= maxX && minY <= maxY && minZ <= maxZ)) {
            throw new IllegalArgumentException(
                    "box from "
                            + minX
                            + ", "
                            + minY
                            + ", "
                            + minZ
                            + " to "
                            + maxX
                            + ", "
                            + maxY
                            + ", "
                            + maxZ
                            + ": expected each number of the first corner to be at most the"
                            + " second's");
        }
    }

    /**
     * Returns a cube around a point.
     *
     * @param half half the length of an edge [m]
     */
    public static Box around(double x, double y, double z, double half) {
        return new Box(x - half, y - half, z - half, x + half, y + half, z + half);
    }
}
