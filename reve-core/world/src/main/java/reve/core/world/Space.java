// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import reve.core.space.Box;
import reve.core.space.BoxIndex;
import reve.core.space.Found;

import java.util.ArrayList;
import java.util.List;
import java.util.function.LongPredicate;
import java.util.function.LongSupplier;

/**
 * Spatial search for bodies by their bounding boxes ({@code boundsMin}, {@code boundsMax}), which
 * the last DERIVE phase computed. The search ignores later moves and changes of shape, does not
 * find items that were added later, and omits removed items. A body without a shape is a point.
 *
 * <p>The search uses a tree of boxes, which only the first search after a DERIVE phase updates. For
 * the thread that owns the world or uses the snapshot.
 */
public final class Space {

    private final ColumnView ids;
    private final ColumnView lows;
    private final ColumnView highs;
    private final LongSupplier version;
    private final LongSupplier removals;
    private final LongPredicate isThere;
    private final BoxIndex index = new BoxIndex();
    private final Found found = new Found();
    private long builtVersion = -1;
    private long builtRemovals;

    /**
     * Creates a search.
     *
     * @param ids ids of the bodies, by row
     * @param version returns a number, 0 or more, that increases when the boxes are computed
     * @param removals returns the number of bodies removed so far
     * @param isThere returns whether a body still exists
     */
    Space(
            ColumnView ids,
            ColumnView lows,
            ColumnView highs,
            LongSupplier version,
            LongSupplier removals,
            LongPredicate isThere) {
        this.ids = ids;
        this.lows = lows;
        this.highs = highs;
        this.version = version;
        this.removals = removals;
        this.isThere = isThere;
    }

    /** Returns the bodies whose boxes intersect or touch a box, in the order of their ids. */
    public List<ItemId> inBox(Box box) {
        inBox(box, found);
        return present(Integer.MAX_VALUE);
    }

    /**
     * Searches like {@link #inBox(Box)}, but writes the ids into an object of the caller. Calls
     * that reuse this object allocate no memory.
     */
    public void inBox(Box box, Found into) {
        update();
        index.inBox(box, into);
        keepPresent(into);
    }

    /** Returns the bodies whose boxes intersect or touch a sphere, in the order of their ids. */
    public List<ItemId> inSphere(double x, double y, double z, double radius) {
        if (!(radius >= 0)) {
            throw new IllegalArgumentException("radius is " + radius + " m, expected 0 or more");
        }
        update();
        index.inSphere(x, y, z, radius, found);
        keepPresent(found);
        return present(Integer.MAX_VALUE);
    }

    /**
     * Returns the bodies nearest to a point. They are ordered by the distance from the point to
     * their boxes (0 inside a box), then by id.
     *
     * @param most maximum number of results
     */
    public List<ItemId> nearest(double x, double y, double z, int most) {
        if (most < 0 || Double.isNaN(x + y + z)) {
            throw new IllegalArgumentException(
                    "nearest "
                            + most
                            + " bodies to "
                            + x
                            + ", "
                            + y
                            + ", "
                            + z
                            + ": expected 0 or more, and numbers");
        }
        update();
        int asked = most;
        while (true) {
            index.nearest(x, y, z, asked, found);
            boolean all = found.size() < asked;
            keepPresent(found);
            if (all || found.size() >= most) {
                return present(most);
            }
            // Some results were bodies that were removed since the DERIVE phase. The search is
            // therefore repeated for a larger number of results.
            asked = 2 * asked;
        }
    }

    private void update() {
        long now = version.getAsLong();
        if (now != builtVersion) {
            int rows = Math.min(ids.rowCount(), Math.min(lows.rowCount(), highs.rowCount()));
            index.build(ids.segment(), lows.segment(), highs.segment(), rows);
            builtVersion = now;
            builtRemovals = removals.getAsLong();
        }
    }

    private void keepPresent(Found bodies) {
        if (removals.getAsLong() != builtRemovals) {
            bodies.keepIf(isThere);
        }
    }

    private List<ItemId> present(int most) {
        int count = Math.min(most, found.size());
        List<ItemId> present = new ArrayList<>(count);
        for (int i = 0; i < count; i++) {
            present.add(new ItemId(found.key(i)));
        }
        return present;
    }
}
