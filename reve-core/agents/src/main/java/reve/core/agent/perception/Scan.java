// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import org.jspecify.annotations.Nullable;

import reve.core.space.BoxIndex;
import reve.core.space.BoxWalk;

import java.util.Arrays;

/** The progress of a lidar's scan of one frame, which may take several slices of time. */
final class Scan {

    /** The part of a scan that comes next. */
    enum Phase {
        /** The scan has not begun. */
        BEGIN,
        /** The shapes are tested one after the other, each with the rays that may meet it. */
        SHAPES,
        /**
         * The rays are tested one after the other against the shapes in the index {@link #rest}.
         */
        RAYS,
        /** The rays are tested one after the other against all shapes. */
        ALL,
        /** The distances are complete. */
        END
    }

    /** Distances of the rays [m]; infinite for a ray that has met nothing. */
    double[] distances = {};

    /** Directions of the rays in the axes of the world, (rays x 3). */
    double[] directions = {};

    /** Number of rays that were cast in the phases RAYS and ALL. */
    int cast;

    Phase phase = Phase.BEGIN;

    /** The walk of the phase SHAPES; null in scans of few rays. */
    @Nullable BoxWalk walk;

    /** Rows of the bodies that the phase RAYS tests. */
    int[] left = {};

    int leftCount;

    /** The boxes of these bodies; null before the first scan with such bodies. */
    @Nullable BoxIndex rest;

    private long moment = SensedWorld.BEFORE_ALL;

    /**
     * Begins a scan, or continues it if it has begun in the same moment.
     *
     * @param now the present moment; see {@link SensedWorld#moment}
     */
    void begin(long now, int rays) {
        if (moment != now) {
            moment = now;
            cast = 0;
            leftCount = 0;
            phase = Phase.BEGIN;
            if (distances.length != rays) {
                distances = new double[rays];
                directions = new double[3 * rays];
            }
            Arrays.fill(distances, Double.POSITIVE_INFINITY);
        }
    }

    /** Adds a body to those that the phase RAYS tests. */
    void leave(int row) {
        if (leftCount == left.length) {
            left = Arrays.copyOf(left, Math.max(16, 2 * leftCount));
        }
        left[leftCount++] = row;
    }
}
