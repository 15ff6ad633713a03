// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.concurrent.atomic.AtomicReference;

/**
 * The evaluation with which a world's thread is busy (a rule, a condition or a Java action), and a
 * count of evaluation steps. The world's thread updates these data. Any thread may read them, for
 * example to report a world that makes no frames.
 */
public final class Activity {
    private final AtomicReference<@Nullable Object> current = new AtomicReference<>();
    private long steps;

    Activity() {}

    /**
     * Begins an activity, which replaces the current one. For the world's thread only.
     *
     * @param what the activity. Any thread may call its {@code toString}, which describes it for
     *     people
     */
    public void begin(Object what) {
        current.setRelease(what);
    }

    /** Ends the current activity. For the world's thread only. */
    public void end() {
        current.setRelease(null);
    }

    /**
     * Ends the current activity and adds its steps to the count. For the world's thread only.
     *
     * @param count number of evaluation steps, the same on every machine
     */
    public void end(long count) {
        steps += count;
        end();
    }

    /** Adds evaluation steps that belong to no activity. For the world's thread only. */
    public void spend(long count) {
        steps += count;
    }

    /** Returns the number of steps counted so far. For the world's thread only. */
    public long steps() {
        return steps;
    }

    /** Returns the current activity; null if there is none. For any thread. */
    public @Nullable Object current() {
        return current.getAcquire();
    }
}
