// SPDX-License-Identifier: Apache-2.0
package reve.worlds.picture;

import java.util.Locale;

/**
 * A scale bar of a picture. Its length is 1, 2 or 5 times a power of ten.
 *
 * @param metres length that the bar stands for [m]
 * @param pixels length of the bar [px]
 */
public record ScaleBar(double metres, double pixels) {

    /** Maximum length of the bar as a fraction of the picture's width. */
    private static final double MOST = 0.25;

    private static final double[] FIGURES = {5, 2, 1};

    /** Tolerance for rounding errors of powers and logarithms. */
    private static final double ROUNDING = 1e-12;

    /**
     * Returns the longest bar that takes at most a quarter of the picture's width.
     *
     * @param metresPerPixel scale of the picture, positive [m/px]
     * @param width width of the picture [px]
     */
    public static ScaleBar of(double metresPerPixel, int width) {
        double most = MOST * width * metresPerPixel;
        int exponent = (int) Math.floor(Math.log10(most) + ROUNDING);
        double metres = power(exponent);
        for (double figure : FIGURES) {
            if (figure * power(exponent) <= most * (1 + ROUNDING)) {
                metres = figure * power(exponent);
                break;
            }
        }
        return new ScaleBar(metres, metres / metresPerPixel);
    }

    /**
     * Returns the power of ten with the fewest digits, for example 0.001 and not 1.0E-3 + 1 ulp.
     */
    private static double power(int exponent) {
        return Double.parseDouble("1e" + exponent);
    }

    /** Returns the length with its unit, such as {@code 2 m} or {@code 50 cm}. */
    public String text() {
        if (metres >= 1e6 || metres < 1e-6) {
            return String.format(Locale.ROOT, "%.0e m", metres)
                    .replaceFirst("e([+-])0?(\\d)", "e$1$2")
                    .replace("e+", "e");
        }
        if (metres >= 1e3) {
            return Math.round(metres / 1e3) + " km";
        }
        if (metres >= 1) {
            return Math.round(metres) + " m";
        }
        if (metres >= 1e-2) {
            return Math.round(metres * 1e2) + " cm";
        }
        return metres >= 1e-3 ? Math.round(metres * 1e3) + " mm" : Math.round(metres * 1e6) + " µm";
    }
}
