// SPDX-License-Identifier: Apache-2.0
package reve.worlds.server;

import java.time.Duration;
import java.util.Optional;

/**
 * When a world counts as standing still, and what happens then beside the report.
 *
 * @param limit time without a frame; 0: worlds are not watched
 * @param onStall called after each report, on the watchdog's thread
 */
public record WatchdogPlan(Duration limit, Optional<Runnable> onStall) {
    /** Watches no world. */
    public static final WatchdogPlan OFF = new WatchdogPlan(Duration.ZERO, Optional.empty());
}
