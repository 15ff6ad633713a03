// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The relation of simulated time to the time of the clock. */
public enum Pacing {
    /**
     * Pacing in which simulated time follows the clock, without drift. {@link FrameProfile} counts
     * the frames that were late.
     */
    REAL_TIME,
    /** Pacing in which frames follow each other as fast as possible. */
    FAST
}
