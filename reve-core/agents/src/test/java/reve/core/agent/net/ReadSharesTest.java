// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import java.util.ArrayDeque;
import java.util.Arrays;
import java.util.Deque;

/**
 * The number of bytes that the server decodes for each connection, with a clock that the test sets.
 */
class ReadSharesTest {
    private static final int LONG_LINE = 59_000;
    private static final long MILLISECOND = 1_000_000;

    private final ReadShares shares = new ReadShares();

    @Test
    void anOrdinaryAgentNeverWaitsBesideHundredsThatSendLongLines() {
        ReadShares.Share agent = shares.open(0);
        Deque<ReadShares.Share> flood = flood(500);
        long next = 0;
        for (long now = 0; now < 2_000 * MILLISECOND; now += MILLISECOND) {
            sendAll(flood, now);
            if (now >= next) {
                assertThat(shares.take(agent, 200, now)).as("at %d ms", now / MILLISECOND).isTrue();
                next += 1_000 * MILLISECOND / 60;
            }
        }
    }

    @Test
    void longLinesOfAnyNumberOfConnectionsShareOnePool() {
        Deque<ReadShares.Share> flood = flood(500);
        long taken = 0;
        for (long now = 0; now < 1_000 * MILLISECOND; now += MILLISECOND) {
            taken += sendAll(flood, now);
        }
        int windows = (int) (1_000 * MILLISECOND / ReadShares.WINDOW_NANOS);
        assertThat(taken)
                .isBetween(
                        (long) windows * ReadShares.POOL,
                        (long) windows * (ReadShares.POOL + LONG_LINE));
    }

    @Test
    void eachOfThoseThatWaitHasItsTurn() {
        ReadShares.Share[] flood = flood(20).toArray(ReadShares.Share[]::new);
        int[] taken = new int[flood.length];
        Deque<Integer> waiting = new ArrayDeque<>();
        for (int i = 0; i < flood.length; i++) {
            waiting.add(i);
        }
        for (long now = 0; now < 2_000 * MILLISECOND; now += ReadShares.WINDOW_NANOS) {
            for (int count = waiting.size(); count > 0 && shares.hasLeft(now); count--) {
                int next = waiting.poll();
                while (shares.take(flood[next], LONG_LINE, now)) {
                    taken[next]++;
                }
                waiting.add(next);
            }
        }
        assertThat(Arrays.stream(taken).min().orElseThrow()).isPositive();
    }

    @Test
    void aSingleAgentInLockStepWithAFastWorldIsNotHeld() {
        ReadShares.Share agent = shares.open(0);
        for (long now = 0; now < 1_000 * MILLISECOND; now += MILLISECOND / 25) {
            assertThat(shares.take(agent, 120, now)).isTrue(); // 25,000 rounds a second
        }
    }

    private Deque<ReadShares.Share> flood(int count) {
        Deque<ReadShares.Share> flood = new ArrayDeque<>();
        for (int i = 0; i < count; i++) {
            flood.add(shares.open(0));
        }
        return flood;
    }

    private long sendAll(Deque<ReadShares.Share> flood, long now) {
        long bytes = 0;
        for (ReadShares.Share each : flood) {
            bytes += shares.take(each, LONG_LINE, now) ? LONG_LINE : 0;
        }
        return bytes;
    }
}
