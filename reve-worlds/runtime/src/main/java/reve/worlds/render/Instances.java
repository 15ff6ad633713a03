// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.util.List;

/**
 * Items of one shape, as columns. A row is one value in each column. Rows may be written item by
 * item or column by column; all columns must have the same length when the scene is rendered.
 */
public final class Instances {

    /** Flag: shows the exact colour and casts no shadow. */
    public static final int UNLIT = 1;

    /** Flag: draws lines at powers of ten of a metre on a plane. */
    public static final int GRID = 2;

    /** Flag: fades a plane into the background away from the camera's target. */
    public static final int FADE = 4;

    private final GrowingColumn positions = new GrowingColumn();
    private final GrowingColumn orientations = new GrowingColumn();
    private final GrowingColumn sizes = new GrowingColumn();
    private final GrowingColumn colours = new GrowingColumn();
    private final GrowingColumn flags = new GrowingColumn();
    private final GrowingColumn items = new GrowingColumn();

    Instances() {}

    /** Adds the position of the origin [m]. */
    public Instances position(double x, double y, double z) {
        positions.add((float) x, (float) y, (float) z);
        return this;
    }

    /** Adds the orientation, a unit quaternion. */
    public Instances orientation(double x, double y, double z, double w) {
        orientations.add((float) x, (float) y, (float) z, (float) w);
        return this;
    }

    /** Adds the extents along the item's own axes [m]; scale factors for a mesh. Not negative. */
    public Instances size(double x, double y, double z) {
        sizes.add((float) x, (float) y, (float) z);
        return this;
    }

    /**
     * Adds a colour.
     *
     * @param rgba see {@link reve.core.world.Colour#rgba()}; alpha is ignored
     */
    public Instances colour(int rgba) {
        colours.add(rgba);
        return this;
    }

    /**
     * Adds flags.
     *
     * @param bits sum of {@link #UNLIT}, {@link #GRID} and {@link #FADE}, or 0
     */
    public Instances flags(int bits) {
        flags.add(bits);
        return this;
    }

    /**
     * Adds the number that pixels of the item have in {@link PixelLayers}.
     *
     * @param number positive, or 0 for no number
     */
    public Instances item(long number) {
        items.add(Math.toIntExact(number));
        return this;
    }

    /**
     * Returns the number of rows.
     *
     * @throws IllegalStateException if the columns have different lengths
     */
    int count() {
        return GrowingColumn.sharedRowCount(columns(), List.of(3, 4, 3, 1, 1, 1));
    }

    List<GrowingColumn> columns() {
        return List.of(positions, orientations, sizes, colours, flags, items);
    }
}
