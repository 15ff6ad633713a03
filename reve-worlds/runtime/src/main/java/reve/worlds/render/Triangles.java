// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.util.List;

/** Flat triangles with a colour at each corner, as columns; see {@link Instances}. */
public final class Triangles {

    private final GrowingColumn corners = new GrowingColumn();
    private final GrowingColumn colours = new GrowingColumn();
    private final GrowingColumn items = new GrowingColumn();

    Triangles() {}

    /**
     * Adds the next corner [m]. Three corners make a triangle.
     *
     * @param rgba see {@link reve.core.world.Colour#rgba()}; alpha is ignored
     */
    public Triangles corner(double x, double y, double z, int rgba) {
        corners.add((float) x, (float) y, (float) z);
        colours.add(rgba);
        return this;
    }

    /**
     * Adds the number of the triangle, which {@link PixelLayers} contains for each of its pixels.
     *
     * @param number positive, or 0 for no number
     */
    public Triangles item(long number) {
        items.add(Math.toIntExact(number));
        return this;
    }

    /**
     * Returns the number of triangles.
     *
     * @throws IllegalStateException if the last triangle lacks a corner
     */
    int count() {
        return GrowingColumn.sharedRowCount(columns(), List.of(9, 3, 1));
    }

    List<GrowingColumn> columns() {
        return List.of(corners, colours, items);
    }
}
