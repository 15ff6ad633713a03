// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

/**
 * The items around a body within a sensor's range and a margin. They are found once, and stay valid
 * for many frames if bodies move slowly. For one thread.
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

    /** Bodies that hid others from this sensor. */
    final Hiders hiders = new Hiders();

    /** Moment of the last perception; before all moments if there is none. */
    long sensedIn;

    /** Number of items that were tested in the moment {@link #begun}. */
    int tested;

    private long begun = SensedWorld.BEFORE_ALL;
    private long arrangement = -1;
    private double path;

    /**
     * Returns whether the items still include all that the sensor can reach.
     *
     * @param nowArrangement version of the world's lists of items
     * @param nowPath upper bound on the distance that any body has moved in total [m]
     */
    boolean holds(double range, long nowArrangement, double nowPath) {
        return arrangement == nowArrangement && isWithinMargin(range, nowPath - path);
    }

    void foundIn(long itsArrangement, double itsPath) {
        arrangement = itsArrangement;
        path = itsPath;
    }

    /**
     * Records a search like {@link #foundIn} without a margin, so that it is valid in this frame
     * only.
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

    /** Returns whether an item and the body together can have moved by at most the margin. */
    static boolean isWithinMargin(double range, double way) {
        return 2 * way <= SAFE * MARGIN * range;
    }
}
