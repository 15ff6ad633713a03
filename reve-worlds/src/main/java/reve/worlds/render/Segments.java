// SPDX-License-Identifier: Apache-2.0
package reve.worlds.render;

import java.util.List;

/** Straight lines of one width as columns; see {@link Instances}. */
public final class Segments {

    private final GrowingColumn starts = new GrowingColumn();
    private final GrowingColumn ends = new GrowingColumn();
    private final GrowingColumn colours = new GrowingColumn();
    private final GrowingColumn items = new GrowingColumn();

    Segments() {}

    /** Where the line begins [m]. */
    public Segments from(double x, double y, double z) {
        starts.add((float) x, (float) y, (float) z);
        return this;
    }

    /** Where the line ends [m]. */
    public Segments to(double x, double y, double z) {
        ends.add((float) x, (float) y, (float) z);
        return this;
    }

    /**
     * @param rgba see {@link reve.core.world.Colour#rgba()}; alpha is not shown
     */
    public Segments colour(int rgba) {
        colours.add(rgba);
        return this;
    }

    /**
     * @param number of what is shown there, positive; 0 for nothing that has one
     */
    public Segments item(long number) {
        items.add(Math.toIntExact(number));
        return this;
    }

    /**
     * @throws IllegalStateException if a column has more rows than another
     */
    int count() {
        return GrowingColumn.sharedRowCount(columns(), List.of(3, 3, 1, 1));
    }

    List<GrowingColumn> columns() {
        return List.of(starts, ends, colours, items);
    }
}
