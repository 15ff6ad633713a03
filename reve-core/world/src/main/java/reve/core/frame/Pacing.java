// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The relation of simulated time to wall time. */
public enum Pacing {
    /**
     * At the speed of wall time, without drift. {@link FrameProfile} counts the frames that were
     * late.
     */
    REAL_TIME,
    /** As fast as possible. */
    FAST
}
