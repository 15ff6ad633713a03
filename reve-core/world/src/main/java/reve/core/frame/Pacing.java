// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The relation of simulated time to wall time. */
public enum Pacing {
    /**
     * Simulated time follows wall time, without drift. {@link FrameProfile} counts the frames that
     * were late.
     */
    REAL_TIME,
    /** Frames follow each other as fast as possible. */
    FAST
}
