// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

class HellosTest {

    private static final long MILLISECOND = 1_000_000;

    @Test
    void aBurstMayJoinAtOnceAndFurtherClientsEveryTenMilliseconds() {
        long now = Long.MAX_VALUE - 5 * MILLISECOND; // System.nanoTime may overflow
        var hellos = new Hellos(3, now);
        assertThat(joins(hellos, now)).isEqualTo(3);
        assertThat(joins(hellos, now + 9 * MILLISECOND)).isZero();
        assertThat(joins(hellos, now + 10 * MILLISECOND)).isEqualTo(1);
        assertThat(joins(hellos, now + 30 * MILLISECOND)).isEqualTo(2);
    }

    @Test
    void quietTimeRestoresTheBurstAndNoMore() {
        var hellos = new Hellos(2, 0);
        joins(hellos, 0);
        assertThat(joins(hellos, 3_600_000 * MILLISECOND)).isEqualTo(2);
    }

    /** Returns how many clients join. */
    private static int joins(Hellos hellos, long now) {
        int joins = 0;
        for (; hellos.haveLeft(now); joins++) {
            hellos.count();
        }
        return joins;
    }
}
