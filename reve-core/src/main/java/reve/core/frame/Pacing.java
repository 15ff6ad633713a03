// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** How fast simulated time passes. */
public enum Pacing {
    /** As fast as wall time, never drifting from it; overload is counted. */
    REAL_TIME,
    /** As fast as possible. */
    FAST
}
