// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.util.Set;

/** Which events of a server are printed. */
enum Printed {
    /** That the worlds are ready, what went wrong, and the end. */
    LITTLE {
        @Override
        boolean includes(String event) {
            return ALWAYS.contains(event);
        }
    },
    /** What happens now and then: nothing that agents bring about in every frame. */
    NORMAL {
        @Override
        boolean includes(String event) {
            return LITTLE.includes(event) || NOW_AND_THEN.contains(event);
        }
    },
    /** Each action, too, and what actions raise. */
    ACTIONS {
        @Override
        boolean includes(String event) {
            return true;
        }
    };

    private static final Set<String> ALWAYS =
            Set.of("ready", "fault", "snapshot-failed", "stalled", "recovered");
    private static final Set<String> NOW_AND_THEN =
            Set.of(
                    "joined",
                    "left",
                    "removed",
                    "late",
                    "away",
                    "back",
                    "law-loaded",
                    "law-unloaded",
                    "snapshot",
                    "saved",
                    "rewound");

    abstract boolean includes(String event);
}
