// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.concurrent.atomic.AtomicReference;

/**
 * The rule, condition or Java action that a world's thread is evaluating now, and a count of
 * evaluation steps. The world's thread updates it; any thread may read it, for example to report a
 * world that makes no frames.
 */
public final class Activity {
    private final AtomicReference<@Nullable Object> current = new AtomicReference<>();
    private long steps;

    Activity() {}

    /**
     * Begins an activity, which replaces the current one. For the world's thread only.
     *
     * @param what the activity; its {@code toString} describes it for people, on any thread
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

    /** Adds steps of work that is not an activity. For the world's thread only. */
    void spend(long count) {
        steps += count;
    }

    /** Returns the number of steps counted so far. For the world's thread only. */
    public long steps() {
        return steps;
    }

    /** Returns the current activity, or null. For any thread. */
    public @Nullable Object current() {
        return current.getAcquire();
    }
}
