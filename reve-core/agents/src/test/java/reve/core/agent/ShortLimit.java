// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import java.time.Duration;
import java.util.List;

/**
 * Tests that wait until a time limit is reached. A busy machine may reach a short limit before a
 * correct client does anything. Such a test is therefore repeated with longer limits. A fault of
 * the server fails the test with each limit.
 */
public final class ShortLimit {
    private static final List<Duration> LIMITS =
            List.of(
                    Duration.ofMillis(150),
                    Duration.ofMillis(1500),
                    Duration.ofSeconds(6),
                    Duration.ofSeconds(30));

    /** A test that waits until a limit is reached. */
    public interface Test {
        /** Runs the test with a limit. */
        void run(Duration limit) throws Exception;
    }

    private ShortLimit() {}

    /** Runs a test with longer and longer limits, until it passes. */
    public static void run(Test test) throws Exception {
        for (Duration limit : LIMITS.subList(0, LIMITS.size() - 1)) {
            try {
                test.run(limit);
                return;
            } catch (AssertionError | Exception tooShort) {
                // the last limit decides
            }
        }
        test.run(LIMITS.getLast());
    }
}
