// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.util.List;

/** Straight lines of one width, as columns; see {@link Instances}. */
public final class Segments {

    private final GrowingColumn starts = new GrowingColumn();
    private final GrowingColumn ends = new GrowingColumn();
    private final GrowingColumn colours = new GrowingColumn();
    private final GrowingColumn items = new GrowingColumn();

    Segments() {}

    /** Adds the start of the line [m]. */
    public Segments from(double x, double y, double z) {
        starts.add((float) x, (float) y, (float) z);
        return this;
    }

    /** Adds the end of the line [m]. */
    public Segments to(double x, double y, double z) {
        ends.add((float) x, (float) y, (float) z);
        return this;
    }

    /**
     * Adds a colour.
     *
     * @param rgba see {@link reve.core.world.Colour#rgba()}; alpha is ignored
     */
    public Segments colour(int rgba) {
        colours.add(rgba);
        return this;
    }

    /**
     * Adds the number of the line, which {@link PixelLayers} contains for each of its pixels.
     *
     * @param number positive, or 0 for no number
     */
    public Segments item(long number) {
        items.add(Math.toIntExact(number));
        return this;
    }

    /**
     * Returns the number of lines.
     *
     * @throws IllegalStateException if the columns have different lengths
     */
    int count() {
        return GrowingColumn.sharedRowCount(columns(), List.of(3, 3, 1, 1));
    }

    List<GrowingColumn> columns() {
        return List.of(starts, ends, colours, items);
    }
}
