// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import java.util.Set;

/** Selects the server events that are printed. */
enum Printed {
    /** Selects few events: that the worlds are ready, faults, and the end. */
    LITTLE {
        @Override
        boolean includes(String event) {
            return ALWAYS.contains(event);
        }
    },
    /** Selects all events except those that agents can cause in every frame. */
    NORMAL {
        @Override
        boolean includes(String event) {
            return LITTLE.includes(event) || NOW_AND_THEN.contains(event);
        }
    },
    /** Selects all events, including each action and the events that actions raise. */
    ACTIONS {
        @Override
        boolean includes(String event) {
            return true;
        }
    };

    private static final Set<String> ALWAYS =
            Set.of(
                    "ready",
                    "standby",
                    "cluster",
                    "fault",
                    "picture-failed",
                    "stalled",
                    "recovered");
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
                    "law-shadow",
                    "over-budget",
                    "picture",
                    "saved",
                    "rewound",
                    "world-asleep",
                    "watching",
                    "level-changed");

    abstract boolean includes(String event);
}
