// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.util.List;

/**
 * Items of one shape as columns. A row is one value in each column; rows may be written item by
 * item or column by column, but all columns are equally long when the scene is rendered.
 */
public final class Instances {

    /** Shown in its exact colour, casts no shadow. */
    public static final int UNLIT = 1;

    /** A plane gets lines at powers of ten of a metre. */
    public static final int GRID = 2;

    /** A plane dissolves into the background away from the camera's target. */
    public static final int FADE = 4;

    private final GrowingColumn positions = new GrowingColumn();
    private final GrowingColumn orientations = new GrowingColumn();
    private final GrowingColumn sizes = new GrowingColumn();
    private final GrowingColumn colours = new GrowingColumn();
    private final GrowingColumn flags = new GrowingColumn();
    private final GrowingColumn items = new GrowingColumn();

    Instances() {}

    /** Place of the origin [m]. */
    public Instances position(double x, double y, double z) {
        positions.add((float) x, (float) y, (float) z);
        return this;
    }

    /** Unit quaternion. */
    public Instances orientation(double x, double y, double z, double w) {
        orientations.add((float) x, (float) y, (float) z, (float) w);
        return this;
    }

    /** Extents along the own axes [m]; for a mesh, factors. Not negative. */
    public Instances size(double x, double y, double z) {
        sizes.add((float) x, (float) y, (float) z);
        return this;
    }

    /**
     * @param rgba see {@link reve.core.world.Colour#rgba()}; alpha is not shown
     */
    public Instances colour(int rgba) {
        colours.add(rgba);
        return this;
    }

    /**
     * @param bits sum of {@link #UNLIT}, {@link #GRID} and {@link #FADE}, or 0
     */
    public Instances flags(int bits) {
        flags.add(bits);
        return this;
    }

    /**
     * @param number of what is shown there, positive; 0 for nothing that has one
     */
    public Instances item(long number) {
        items.add(Math.toIntExact(number));
        return this;
    }

    /**
     * @throws IllegalStateException if a column has more rows than another
     */
    int count() {
        return GrowingColumn.sharedRowCount(columns(), List.of(3, 4, 3, 1, 1, 1));
    }

    List<GrowingColumn> columns() {
        return List.of(positions, orientations, sizes, colours, flags, items);
    }
}
