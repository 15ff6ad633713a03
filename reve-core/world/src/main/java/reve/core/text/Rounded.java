// SPDX-License-Identifier: Apache-2.0
package reve.core.text;

import java.math.BigDecimal;
import java.math.MathContext;
import java.math.RoundingMode;

/**
 * Formatter of numbers for people. A number has four significant digits, and an exponent only if it
 * is very large or very small.
 */
public final class Rounded {
    private static final MathContext FOUR = new MathContext(4, RoundingMode.HALF_UP);
    private static final double PLAIN_FROM = 1e-4;
    private static final double PLAIN_BELOW = 1e7;

    private Rounded() {}

    /**
     * Returns a number with at most four significant digits. A whole number keeps all of its digits
     * unless it is very large.
     */
    public static String of(double number) {
        if (!Double.isFinite(number)) {
            return Double.toString(number);
        }
        double size = Math.abs(number);
        if (size == 0) {
            return "0";
        }
        if (size < PLAIN_BELOW && number == Math.rint(number)) {
            return Long.toString((long) number);
        }
        BigDecimal rounded = new BigDecimal(number).round(FOUR).stripTrailingZeros();
        return size >= PLAIN_FROM && size < PLAIN_BELOW
                ? rounded.toPlainString()
                : scientific(rounded);
    }

    private static String scientific(BigDecimal number) {
        String digits = number.unscaledValue().abs().toString();
        int exponent = digits.length() - 1 - number.scale();
        return (number.signum() < 0 ? "-" : "")
                + digits.charAt(0)
                + (digits.length() > 1 ? "." + digits.substring(1) : "")
                + "e"
                + exponent;
    }
}
