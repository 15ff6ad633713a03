// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import java.util.Optional;

/**
 * The measures of a terrain, which is a mesh over a grid of heights. Immutable.
 *
 * @param x extent along the X axis [m]
 * @param z extent along the Z axis [m]
 * @param range heights of black and white, if the heights are those of an image
 */
public record Relief(double x, double z, Optional<Range> range) {
    /**
     * Heights between which the brightness of an image chooses.
     *
     * @param least height of black [m]
     * @param greatest height of white [m]
     */
    public record Range(double least, double greatest) {
        /** Checks the order of the heights. */
        public Range {
            if (!(least < greatest)) {
                throw new IllegalArgumentException(
                        "heightRange: found "
                                + least
                                + " and "
                                + greatest
                                + " m, expected the height of black and a greater one of white");
            }
        }
    }

    /** Returns the height [m] for a number of the grid: a height, or a brightness from 0 to 1. */
    public double height(double value) {
        return range.map(heights -> heights.least + value * (heights.greatest - heights.least))
                .orElse(value);
    }

    /** Returns the triangles of a grid of vertices, counter-clockwise as seen from above. */
    public static int[] triangles(int rows, int columns) {
        int[] triangles = new int[6 * (rows - 1) * (columns - 1)];
        int next = 0;
        for (int j = 0; j + 1 < rows; j++) {
            for (int i = 0; i + 1 < columns; i++) {
                int a = j * columns + i;
                int c = a + columns;
                for (int corner : new int[] {a, c, a + 1, a + 1, c, c + 1}) {
                    triangles[next++] = corner;
                }
            }
        }
        return triangles;
    }
}
