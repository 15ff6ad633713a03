// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

class HellosTest {

    private static final long MILLISECOND = 1_000_000;

    @Test
    void aBurstIsAnsweredAtOnceAndFurtherHellosEveryTenMilliseconds() {
        long now = Long.MAX_VALUE - 5 * MILLISECOND; // System.nanoTime may overflow
        var hellos = new Hellos(3, now);
        for (int i = 0; i < 3; i++) {
            assertThat(hellos.arrive(now) - now).isLessThanOrEqualTo(0);
        }
        assertThat(hellos.arrive(now) - now).isEqualTo(10 * MILLISECOND);
        assertThat(hellos.arrive(now) - now).isEqualTo(20 * MILLISECOND);
        long later = now + 25 * MILLISECOND;
        assertThat(hellos.arrive(later) - later).isEqualTo(5 * MILLISECOND);
    }

    @Test
    void quietTimeRestoresTheBurstAndNoMore() {
        var hellos = new Hellos(2, 0);
        for (int i = 0; i < 10; i++) {
            hellos.arrive(0);
        }
        long later = 3_600_000 * MILLISECOND;
        assertThat(hellos.arrive(later)).isLessThanOrEqualTo(later);
        assertThat(hellos.arrive(later)).isLessThanOrEqualTo(later);
        assertThat(hellos.arrive(later)).isEqualTo(later + 10 * MILLISECOND);
    }
}
