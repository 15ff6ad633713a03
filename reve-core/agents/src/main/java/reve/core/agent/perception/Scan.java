// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import java.util.Arrays;

/** The progress of a lidar's scan of one frame, which may take several slices of time. */
final class Scan {

    /** Distances of the rays that were cast [m]; infinite for a ray that met nothing. */
    double[] distances = {};

    /** Number of rays that were cast. */
    int cast;

    private long moment = SensedWorld.BEFORE_ALL;

    /** Begins the scan of a moment ({@link SensedWorld#moment}), or continues it. */
    void begin(long now, int rays) {
        if (moment != now) {
            moment = now;
            cast = 0;
            if (distances.length != rays) {
                distances = new double[rays];
            }
            Arrays.fill(distances, Double.POSITIVE_INFINITY);
        }
    }
}
