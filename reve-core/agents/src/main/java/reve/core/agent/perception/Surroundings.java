// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

/**
 * What is around a body as far as one of its sensors may reach while nothing moves far: found once,
 * and true for many frames in a world where things move slowly. One thread.
 */
final class Surroundings {

    /** How much further than the sensor is looked, as a share of its range. */
    static final double MARGIN = 0.1;

    /** Of the margin, what rounding may take. */
    private static final double SAFE = 0.99;

    int[] items = {};
    int count;

    /** What the sensor made of each when it last sensed; null for what it did not sense. */
    @Nullable PerceivedItem[] sensed = {};

    /** What was hidden from it, and by what. */
    final Hiders hiders = new Hiders();

    /** The moment of the bodies when it last sensed; before all of them if it has not. */
    long sensedIn;

    private long arrangement = -1;
    private double path;

    /**
     * Whether it still holds all that the sensor may reach.
     *
     * @param nowArrangement which items are where in the world's lists
     * @param nowPath the way that nothing in the world has gone further than [m]
     */
    boolean holds(double range, long nowArrangement, double nowPath) {
        return arrangement == nowArrangement && isWithinMargin(range, nowPath - path);
    }

    void foundIn(long itsArrangement, double itsPath) {
        arrangement = itsArrangement;
        path = itsPath;
    }

    /** As {@link #foundIn}, without a margin: it holds in no other frame. */
    void foundOnce() {
        arrangement = -1;
    }

    /** Makes room for that many, of which nothing is known. */
    void reserve(int items) {
        if (this.items.length < items) {
            this.items = new int[items + items / 4];
            sensed = new PerceivedItem[this.items.length];
        }
        count = items;
        sensedIn = SensedWorld.BEFORE_ALL;
    }

    /** Whether item and body together can have gone no further than the margin. */
    static boolean isWithinMargin(double range, double way) {
        return 2 * way <= SAFE * MARGIN * range;
    }
}
