// SPDX-License-Identifier: Apache-2.0
package reve.core.agent;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

class SlowReadersTest {
    private static final int LARGE = 100_000;

    private final SlowReaders<String> slow = new SlowReaders<>(3 * LARGE);

    @Test
    void whoHasBeenSlowForTheLongestIsInExcess() {
        for (String name : new String[] {"ada", "bob", "cyd"}) {
            slow.hold(name, LARGE);
        }
        assertThat(slow.excess()).isEmpty();
        slow.hold("dan", LARGE);
        assertThat(slow.excess()).containsExactly("ada");
        slow.hold("eve", 2 * LARGE);
        assertThat(slow.excess()).containsExactly("bob", "cyd");
        assertThat(slow.excess()).isEmpty();
    }

    @Test
    void whoHasReadDoesNotCountAndWhoIsWrittenToAgainComesLast() {
        slow.hold("ada", LARGE);
        slow.hold("bob", LARGE);
        slow.release("bob");
        slow.hold("cyd", LARGE);
        slow.hold("ada", LARGE);
        slow.hold("dan", LARGE);
        assertThat(slow.excess()).isEmpty();
        slow.hold("eve", LARGE);
        assertThat(slow.excess()).containsExactly("cyd");
    }

    @Test
    void whoHasWaitedForTheLongestIsInExcessHoweverOftenMoreIsAddedToItsQueue() {
        slow.hold("ada", LARGE);
        slow.hold("bob", LARGE);
        slow.count("ada", 2 * LARGE);
        assertThat(slow.excess()).isEmpty();
        slow.count("bob", LARGE + 1);
        assertThat(slow.excess()).containsExactly("ada");
        slow.count("ada", 2 * LARGE);
        assertThat(slow.excess()).containsExactly("bob");
        slow.count("ada", 10);
        slow.count("cyd", 3 * LARGE);
        assertThat(slow.excess()).isEmpty();
    }

    @Test
    void shortRestsDoNotCount() {
        for (int i = 0; i < 1000; i++) {
            slow.hold("n" + i, 10_000);
        }
        assertThat(slow.excess()).isEmpty();
    }
}
