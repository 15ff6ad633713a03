// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.perception;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.within;

import org.junit.jupiter.api.Test;

import reve.core.world.ItemId;

import java.util.HashSet;
import java.util.Set;

/** The noise of instruments has the stated distribution, and the same bits for the same inputs. */
class MeasurementNoiseTest {
    private static final int MEASUREMENTS = 40_000;
    private static final double DEVIATION = 0.25;

    /** One measurement of three numbers for each frame. */
    private static double[] measured(long seed, long item, String sensor) {
        double[] all = new double[3 * MEASUREMENTS];
        for (int frame = 0; frame < MEASUREMENTS; frame++) {
            var noise = new MeasurementNoise(seed, new ItemId(item), sensor, frame / 60.0);
            for (int i = 0; i < 3; i++) {
                all[3 * frame + i] = noise.next(DEVIATION);
            }
        }
        return all;
    }

    private static double correlation(double[] a, double[] b, int shift) {
        double sum = 0;
        int count = a.length - shift;
        for (int i = 0; i < count; i++) {
            sum += a[i] * b[i + shift];
        }
        return sum / count / (DEVIATION * DEVIATION);
    }

    /** The bounds are four standard errors of the estimates. */
    @Test
    void itIsNormallyDistributedWithTheStatedDeviation() {
        double[] noise = measured(7, 3, "imu");
        int n = noise.length;
        double mean = 0;
        double within1 = 0;
        double within2 = 0;
        for (double value : noise) {
            mean += value / n;
            within1 += Math.abs(value) < DEVIATION ? 1.0 / n : 0;
            within2 += Math.abs(value) < 2 * DEVIATION ? 1.0 / n : 0;
        }
        double error = 4 / Math.sqrt(n);
        assertThat(mean).isCloseTo(0, within(DEVIATION * error));
        assertThat(correlation(noise, noise, 0)).isCloseTo(1, within(Math.sqrt(2) * error));
        assertThat(within1).isCloseTo(0.682689, within(0.5 * error));
        assertThat(within2).isCloseTo(0.954500, within(0.21 * error));
    }

    @Test
    void componentsFramesItemsSensorsAndSeedsAreIndependent() {
        double[] noise = measured(7, 3, "imu");
        double error = 4 / Math.sqrt(noise.length);
        for (int shift = 1; shift < 7; shift++) {
            assertThat(correlation(noise, noise, shift)).isCloseTo(0, within(error));
        }
        for (double[] other :
                new double[][] {
                    measured(8, 3, "imu"), measured(7, 4, "imu"), measured(7, 3, "tilt")
                }) {
            assertThat(correlation(noise, other, 0)).isCloseTo(0, within(error));
        }
    }

    @Test
    void theSameInputsGiveTheSameBits() {
        var one = new MeasurementNoise(1, new ItemId(2), "a", 0.5);
        var other = new MeasurementNoise(1, new ItemId(2), "a", 0.5);
        Set<Double> values = new HashSet<>();
        for (int i = 0; i < 100; i++) {
            double value = one.next(1);
            assertThat(other.next(1)).isEqualTo(value);
            assertThat(values.add(value)).isTrue();
        }
        assertThat(one.next(0)).isZero();
    }
}
