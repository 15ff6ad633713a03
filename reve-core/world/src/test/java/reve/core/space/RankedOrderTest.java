// SPDX-License-Identifier: Apache-2.0
package reve.core.space;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;

import reve.core.Seed;

import java.util.Random;

class RankedOrderTest {

    @Test
    void sortableBitsRiseWithTheNumbersAlsoBeyondFloats() {
        long seed = Seed.of("sortable");
        var random = new Random(seed);
        double[] values =
                random.doubles(2000, -308, 308)
                        .map(power -> (random.nextBoolean() ? 1 : -1) * Math.pow(10, power))
                        .sorted()
                        .toArray();
        for (int i = 1; i < values.length; i++) {
            assertThat(
                            Integer.compareUnsigned(
                                    RankedOrder.sortable(values[i - 1]),
                                    RankedOrder.sortable(values[i])))
                    .as("seed %d: %s and %s", seed, values[i - 1], values[i])
                    .isLessThanOrEqualTo(0);
        }
        assertThat(RankedOrder.sortable(1.01e100)).isNotEqualTo(RankedOrder.sortable(1e100));
        assertThat(RankedOrder.sortable(Double.POSITIVE_INFINITY))
                .isNotEqualTo(RankedOrder.sortable(Double.MAX_VALUE / 2));
        assertThat(
                        Integer.compareUnsigned(
                                RankedOrder.sortable(0x1p128),
                                RankedOrder.sortable(Float.MAX_VALUE)))
                .isPositive();
    }
}
