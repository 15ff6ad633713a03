// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

/**
 * The items around a body within a sensor's range plus a margin. One search finds them, and its
 * result stays valid for many frames if bodies move slowly. For one thread.
 */
final class Surroundings {

    /** Margin as a fraction of the sensor's range. */
    static final double MARGIN = 0.1;

    /** Fraction of the margin left after rounding errors. */
    private static final double SAFE = 0.99;

    int[] items = {};
    int count;

    /** The sensor's last perception of each item; null for items that it did not sense. */
    @Nullable PerceivedItem[] sensed = {};

    /** The bodies that last hid other bodies from this sensor. */
    final Hiders hiders = new Hiders();

    /**
     * Moment ({@link SensedWorld#moment}) of the last perception; {@link SensedWorld#BEFORE_ALL} if
     * there is none.
     */
    long sensedIn;

    /** Number of items that were tested since the moment {@link #begun}. */
    int tested;

    private long begun = SensedWorld.BEFORE_ALL;
    private long arrangement = -1;
    private double path;

    /**
     * Returns whether the items found still include all items that the sensor can reach.
     *
     * @param nowArrangement current version of the assignment of items to rows
     * @param nowPath upper bound on the total distance that any body has moved so far [m]
     */
    boolean holds(double range, long nowArrangement, double nowPath) {
        return arrangement == nowArrangement && isWithinMargin(range, nowPath - path);
    }

    void foundIn(long itsArrangement, double itsPath) {
        arrangement = itsArrangement;
        path = itsPath;
    }

    /**
     * Records a search without a margin, whose result is valid in this frame only. The caller calls
     * this method instead of {@link #foundIn}.
     */
    void foundOnce() {
        arrangement = -1;
    }

    /** Begins to test the items in a moment. */
    void begin(long moment) {
        begun = moment;
        tested = 0;
    }

    /** Returns whether the test of the items has begun in this moment, and may be continued. */
    boolean isBegun(long moment) {
        return begun == moment;
    }

    /** Allocates space for that number of items, without perceptions. */
    void reserve(int items) {
        if (this.items.length < items) {
            this.items = new int[items + items / 4];
            sensed = new PerceivedItem[this.items.length];
        }
        count = items;
        sensedIn = SensedWorld.BEFORE_ALL;
    }

    /**
     * Returns whether an item and the body have come closer to each other by at most the margin.
     *
     * @param way maximum distance that each of the two has moved [m]
     */
    static boolean isWithinMargin(double range, double way) {
        return 2 * way <= SAFE * MARGIN * range;
    }
}
