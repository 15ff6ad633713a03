// SPDX-License-Identifier: Apache-2.0
package reve.agent;

import java.time.Duration;
import java.util.Optional;

/**
 * The world waits for the agent after every so many frames.
 *
 * @param every frames between perceptions
 * @param relations whether symbols hold what is near, on, inside and touching, too
 * @param deadline longest wait
 * @param fallback what the agent's body does when that was not long enough
 */
public record LockStep(int every, boolean relations, Duration deadline, Optional<Act> fallback) {

    static final Duration DEADLINE = Duration.ofSeconds(1);

    /** After that many frames, at most a second. */
    public static LockStep every(int frames) {
        return new LockStep(frames, false, DEADLINE, Optional.empty());
    }

    /** The same, with relations among the symbols. */
    public LockStep withRelations() {
        return new LockStep(every, true, deadline, fallback);
    }

    /** The same with another longest wait. */
    public LockStep withDeadline(Duration longest) {
        return new LockStep(every, relations, longest, fallback);
    }

    /** The same; the body does this when the agent is late. */
    public LockStep withFallback(Act act) {
        return new LockStep(every, relations, deadline, Optional.of(act));
    }
}
