// SPDX-License-Identifier: Apache-2.0
package reve.core.frame;

import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.atomic.AtomicLongArray;

/**
 * A histogram of the durations of frames. One thread adds durations, which allocates nothing. Any
 * thread may read the numbers.
 */
final class FrameTimes {
    private static final long[] BOUNDS =
            FrameProfile.TIME_BOUNDS_SECONDS.stream()
                    .mapToLong(seconds -> Math.round(seconds * 1e9))
                    .toArray();

    private final AtomicLongArray counts = new AtomicLongArray(BOUNDS.length + 1);

    /** Adds the duration of one frame [ns]. */
    void add(long nanoseconds) {
        int bucket = 0;
        while (bucket < BOUNDS.length && nanoseconds > BOUNDS[bucket]) {
            bucket++;
        }
        counts.setRelease(bucket, counts.getPlain(bucket) + 1);
    }

    /** Returns the numbers of frames, as in {@link FrameProfile#framesByTime}. */
    List<Long> counts() {
        List<Long> all = new ArrayList<>(counts.length());
        for (int i = 0; i < counts.length(); i++) {
            all.add(counts.getAcquire(i));
        }
        return all;
    }
}
