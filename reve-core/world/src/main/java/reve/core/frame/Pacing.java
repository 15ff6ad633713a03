// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

/** The speed of simulated time. */
public enum Pacing {
    /** At the speed of wall time, without drift; overload is counted. */
    REAL_TIME,
    /** As fast as possible. */
    FAST
}
