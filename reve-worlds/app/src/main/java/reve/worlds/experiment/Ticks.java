// SPDX-License-Identifier: Apache-2.0
package reve.worlds.experiment;

import java.math.BigDecimal;
import java.math.RoundingMode;
import java.util.ArrayList;
import java.util.List;

/**
 * The range of an axis, with tick marks at round numbers in equal distances.
 *
 * @param from lower end of the axis
 * @param to upper end of the axis, above {@code from}
 * @param step distance of two tick marks: 1, 2 or 5 times a power of ten
 */
record Ticks(double from, double to, BigDecimal step) {
    private static final double MARGIN = 0.04;
    private static final int MAX_PLAIN_SCALE = 6;
    private static final int MIN_PLAIN_SCALE = -6;

    /**
     * Returns the axis for values between two finite numbers.
     *
     * @param count wanted number of steps
     */
    static Ticks of(double least, double greatest, int count) {
        double middle = least / 2 + greatest / 2;
        double half = greatest / 2 - least / 2;
        if (half <= Math.abs(middle) * 1e-12) {
            half = middle == 0 ? 1 : Math.abs(middle) * 0.05;
        }
        half *= 1 + 2 * MARGIN;
        double from = middle - half;
        double to = middle + half;
        if (least >= 0 && from < 0) {
            from = 0; // an axis of positive numbers has no negative part
        }
        return new Ticks(from, to, step((to - from) / count));
    }

    private static BigDecimal step(double wanted) {
        int power = (int) Math.floor(Math.log10(Math.max(wanted, Double.MIN_NORMAL)));
        double digit = wanted / Math.pow(10, power);
        int rounded = digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10;
        return BigDecimal.valueOf(rounded).scaleByPowerOfTen(power);
    }

    /** Returns the numbers at the tick marks, in ascending order. */
    List<BigDecimal> numbers() {
        List<BigDecimal> numbers = new ArrayList<>();
        BigDecimal first =
                new BigDecimal(from).divide(step, 0, RoundingMode.CEILING).multiply(step);
        BigDecimal last = new BigDecimal(to);
        for (BigDecimal each = first; each.compareTo(last) <= 0; each = each.add(step)) {
            numbers.add(each);
        }
        return numbers;
    }

    /** Returns the text of one of the numbers. */
    String text(BigDecimal number) {
        if (number.signum() == 0) {
            return "0";
        }
        BigDecimal shortest = number.stripTrailingZeros();
        return shortest.scale() <= MAX_PLAIN_SCALE && shortest.scale() >= MIN_PLAIN_SCALE
                ? shortest.toPlainString()
                : shortest.toString();
    }

    /** Returns the position of a number on the axis: 0 at the lower end, 1 at the upper end. */
    double place(double number) {
        return (number - from) / (to - from);
    }
}
