// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.time.Duration;
import java.util.Optional;

/**
 * The time after which a world counts as stalled, and an action that is taken in addition to the
 * report.
 *
 * @param limit time without a frame; 0 disables the watchdog
 * @param onStall called after each report, on the watchdog's thread
 */
public record WatchdogPlan(Duration limit, Optional<Runnable> onStall) {
    /** A plan that watches no world. */
    public static final WatchdogPlan OFF = new WatchdogPlan(Duration.ZERO, Optional.empty());
}
