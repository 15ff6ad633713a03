// SPDX-License-Identifier: Apache-2.0
package reve.core.world;

import org.jspecify.annotations.Nullable;

import java.util.concurrent.atomic.AtomicReference;

/**
 * What the thread of a world does now: the rule, condition or Java action that a frame would wait
 * for if it did not end. The world's thread says so; any thread may ask, for example one that
 * reports a world without frames.
 */
public final class Activity {
    private final AtomicReference<@Nullable Object> current = new AtomicReference<>();
    private long steps;

    Activity() {}

    /**
     * Begins something, which replaces what was current. World's thread.
     *
     * @param what its {@code toString} names it for a person, and is safe on any thread
     */
    public void begin(Object what) {
        current.setRelease(what);
    }

    /** Ends what was begun last. World's thread. */
    public void end() {
        current.setRelease(null);
    }

    /**
     * Ends what was begun last. World's thread.
     *
     * @param its steps, the same number on every machine
     */
    public void end(long its) {
        steps += its;
        end();
    }

    /** Counts steps of what is no evaluation. World's thread. */
    void spend(long its) {
        steps += its;
    }

    /** Returns the steps of all that has ended. World's thread. */
    public long steps() {
        return steps;
    }

    /** Returns what is done now, or null. Any thread. */
    public @Nullable Object current() {
        return current.getAcquire();
    }
}
