// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.util.List;

/**
 * Drawn objects of one shape, as columns. Each object has one row in each column. Rows may be
 * written item by item or column by column. All columns must have the same length when the scene is
 * rendered.
 */
public final class Instances {

    /** Flag: draws the exact colour, without light. The object casts no shadow. */
    public static final int UNLIT = 1;

    /** Flag: draws grid lines on a plane, at distances of powers of ten of a metre. */
    public static final int GRID = 2;

    /** Flag: fades a plane into the background with growing distance from the camera's target. */
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

    /**
     * Adds the extents along the object's own axes [m]; for a mesh, scale factors. Not negative.
     */
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
     * Adds the number of the object, which {@link PixelLayers} contains for each of its pixels.
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
