// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.agent.protocol.Rope;

class SlowReadersTest {
    private static final int LARGE = 100_000;

    private final SlowReaders<String> slow = new SlowReaders<>(3 * LARGE);

    @Test
    void whoHasBeenSlowForTheLongestIsInExcess() {
        for (String name : new String[] {"ada", "bob", "cyd"}) {
            slow.hold(name, rope(LARGE));
        }
        assertThat(slow.excess()).isEmpty();
        slow.hold("dan", rope(LARGE));
        assertThat(slow.excess()).containsExactly("ada");
        slow.hold("eve", rope(2 * LARGE));
        assertThat(slow.excess()).containsExactly("bob", "cyd");
        assertThat(slow.excess()).isEmpty();
    }

    @Test
    void whoHasReadDoesNotCountAndWhoIsWrittenToAgainComesLast() {
        slow.hold("ada", rope(LARGE));
        slow.hold("bob", rope(LARGE));
        slow.release("bob");
        slow.hold("cyd", rope(LARGE));
        slow.hold("ada", rope(LARGE));
        slow.hold("dan", rope(LARGE));
        assertThat(slow.excess()).isEmpty();
        slow.hold("eve", rope(LARGE));
        assertThat(slow.excess()).containsExactly("cyd");
    }

    @Test
    void whoHasWaitedForTheLongestIsInExcessHoweverOftenMoreIsAddedToItsQueue() {
        slow.hold("ada", rope(LARGE));
        slow.hold("bob", rope(LARGE));
        slow.count("ada", LARGE);
        assertThat(slow.excess()).isEmpty();
        slow.count("bob", 1);
        assertThat(slow.excess()).containsExactly("ada");
        slow.count("ada", 2 * LARGE);
        assertThat(slow.excess()).containsExactly("bob");
        slow.count("ada", 10);
        slow.count("cyd", 3 * LARGE);
        assertThat(slow.excess()).isEmpty();
    }

    @Test
    void whatSeveralWaitForCountsOnce() {
        Rope shared = rope(LARGE);
        for (int i = 0; i < 100; i++) {
            var held = new Rope(new byte[1], new Rope[] {shared}, new int[] {1});
            slow.hold("n" + i, held);
        }
        assertThat(slow.excess()).isEmpty();
        assertThat(slow.bytes()).isBetween((long) LARGE, LARGE + 2000L);
        for (int i = 0; i < 99; i++) {
            slow.release("n" + i);
        }
        assertThat(slow.bytes()).isGreaterThan(LARGE);
        slow.release("n99");
        assertThat(slow.bytes()).isZero();
    }

    private static Rope rope(int bytes) {
        return new Rope(new byte[bytes]);
    }

    @Test
    void shortRestsDoNotCount() {
        for (int i = 0; i < 1000; i++) {
            slow.hold("n" + i, rope(10_000));
        }
        assertThat(slow.excess()).isEmpty();
    }
}
