// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.time.Duration;
import java.util.Optional;

/**
 * Settings of lock-step: the world waits for the agent at fixed intervals.
 *
 * @param every frames between perceptions
 * @param relations whether the items' symbols contain relations to other items (near, on, inside,
 *     touching)
 * @param deadline maximum time that the world waits for the agent
 * @param fallback the act of the agent's body if the deadline is missed
 */
public record LockStep(int every, boolean relations, Duration deadline, Optional<Act> fallback) {

    static final Duration DEADLINE = Duration.ofSeconds(1);

    /** Returns lock-step every {@code frames} frames, with a deadline of one second. */
    public static LockStep every(int frames) {
        return new LockStep(frames, false, DEADLINE, Optional.empty());
    }

    /** Returns a copy whose perceptions contain relations between items. */
    public LockStep withRelations() {
        return new LockStep(every, true, deadline, fallback);
    }

    /** Returns a copy with another deadline. */
    public LockStep withDeadline(Duration longest) {
        return new LockStep(every, relations, longest, fallback);
    }

    /** Returns a copy with an act that the server executes when the agent misses the deadline. */
    public LockStep withFallback(Act act) {
        return new LockStep(every, relations, deadline, Optional.of(act));
    }
}
